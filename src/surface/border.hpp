/// The loops of a patch as obstacles in its parameters. Private to the room.
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// Knows two ways: of a convex polygon the half-planes of its sides, of any other loops short pieces of their curves.
class SurfaceModel::Border {
  public:
    /// @param curves  of the model; their images are kept by reference
    Border(const std::vector<std::vector<UseRef>>& loops, std::span<const ModelCurve> curves);

    std::optional<Exit> exit(const Eigen::Vector2d& from, const Eigen::Vector2d& step) const;
    std::vector<OnBorder> touching(const Eigen::Vector2d& uv, double tolerance) const;
    bool contains(const Eigen::Vector2d& uv) const;
    const Eigen::AlignedBox2d& box() const { return box_; }

  private:
    struct Side {
        UseRef use;
        const PlaneCurve* image;
        bool reversed;
        Eigen::Vector2d start, outward;  // of the straight side of a convex polygon
        int first_piece = 0;
        Eigen::AlignedBox2d box;
    };
    // Between two parameters the curve is within `bulge` of its chord.
    struct Piece {
        double t0, t1;
        Eigen::Vector2d a, b;
        double bulge;
    };
    bool is_convex_polygon(std::span<const Side> loop) const;
    void cut(Side& side);
    std::span<const Piece> pieces_of(std::size_t side) const;
    std::optional<Exit> exit_polygon(const Eigen::Vector2d& from, const Eigen::Vector2d& step) const;
    std::optional<Exit> exit_curves(const Eigen::Vector2d& from, const Eigen::Vector2d& step) const;

    std::vector<Side> sides_;
    std::vector<Piece> pieces_;
    Eigen::AlignedBox2d box_;
    bool convex_ = false;
};

}  // namespace gradus
