/// What is wrong with an indexed set of triangles, and the way from it to a mesh.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus {

/// Things found: all are counted, the first kListed are listed, in increasing order.
template <class Item>
struct Findings {
    static constexpr std::size_t kListed = 100;
    std::size_t count = 0;
    std::vector<Item> first;

    bool empty() const { return count == 0; }
    void add(const Item& item) {
        if (count++ < kListed) first.push_back(item);
    }
};

/// Vertices, triangles and edges are named by their indices; an edge by its two vertices, the smaller first. Topology
/// is that of the *sound* triangles: indices in range, none repeated, and not the copy of an earlier triangle.
struct Diagnosis {
    using Edge = std::array<int, 2>;
    using Copy = std::array<int, 2>;  ///< the first, and its copy

    std::size_t num_points = 0;     ///< used or not
    std::size_t num_triangles = 0;  ///< sound or not
    std::size_t num_edges = 0;      ///< of sound triangles

    Findings<int> bad_numbers;     ///< vertices with a coordinate that is infinite or not a number
    Findings<int> out_of_range;    ///< triangles with an index that is no vertex
    Findings<int> repeated_index;  ///< triangles that have a vertex twice
    Findings<int> zero_area;  ///< other triangles whose corners are on a line, to within rounding of the coordinates
    Findings<Copy> duplicate_triangles;   ///< same three vertices, in any order
    Findings<Copy> duplicate_vertices;    ///< same coordinates, bit by bit but for the sign of 0
    Findings<int> unused_vertices;        ///< in no triangle
    Findings<Edge> non_manifold_edges;    ///< with three triangles or more
    Findings<Edge> inconsistent_edges;    ///< with two triangles that run along it in the same direction
    Findings<int> non_manifold_vertices;  ///< bow ties: more than one fan of triangles

    std::size_t boundary_edges = 0;
    std::size_t boundary_loops = 0;  ///< of the surface cut open at bow ties
    std::size_t components = 0;      ///< triangles connected by edges
    long euler_characteristic = 0;   ///< vertices - edges + triangles, those in use
    bool closed = false;             ///< there are triangles, and no boundary
};

/// O(n log n), by sorting.
Diagnosis diagnose(const TriangleSoup& soup);

/// Whether to_mesh() takes it: finite coordinates, sound triangles, manifold, consistently oriented. Boundaries, unused
/// and duplicate vertices and flat triangles are allowed.
bool is_manifold(const Diagnosis& diagnosis);

/// is_manifold(), and nothing else was found either.
bool is_clean_manifold(const Diagnosis& diagnosis);

/// A few lines for people: size and topology, then a line for each kind of fault with its count and the first few
/// cases.
std::string summary(const Diagnosis& diagnosis);

/// The first faults that keep a soup from being is_manifold(), on one line; empty if it is.
std::string why_not_manifold(const Diagnosis& diagnosis);

/// The mesh of a soup, with the same vertex and face indices.
/// @throws std::invalid_argument with the first reasons if the soup is not is_manifold()
TriMesh to_mesh(const TriangleSoup& soup);

}  // namespace gradus
