/// What the cells of finite-element files become: faces become triangles, lines feature edges, volumes are refused.
#pragma once

#include <span>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus::io {

enum class Shape { Nothing, Lines, Polygon, Pixel, Strip, Volume };

/// A kind of cell of a format. Its nodes are the corners first, then those in the middle of sides and inside.
struct CellKind {
    int type;  ///< number in the format
    Shape shape;
    int corners;       ///< least number if there are `any` nodes
    int nodes;         ///< 0: any number, all of them corners
    const char* name;  ///< in the plural
};

class SurfaceCells {
  public:
    std::size_t size() const { return num_cells_; }

    /// Adds the next cell to the triangles or edges of a soup. @param nodes  points, as many as the kind has
    void add(TriangleSoup& soup, const CellKind& kind, std::span<const int> nodes);

    /// Cell each triangle is of, from 0 in the order of add.
    const std::vector<int>& cell_of_triangle() const { return cell_of_triangle_; }
    /// The same of each edge.
    const std::vector<int>& cell_of_edge() const { return cell_of_edge_; }

    /// Values of all cells become values of the triangles.
    Field on_triangles(const Field& on_cells) const;

    /// Removes points that served only as middles of sides, with their values.
    void drop_middles(MeshData& data) const;

  private:
    void add_triangle(TriangleSoup& soup, int a, int b, int c);

    std::size_t num_cells_ = 0;
    std::vector<int> cell_of_triangle_, cell_of_edge_;
    std::vector<int> middles_;
};

}  // namespace gradus::io
