/// Sizes from curvature: how long an edge may be where the surface has a given minimal radius of curvature.
#pragma once

#include "gradus/control/background.hpp"

#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace gradus {

/// Of a default hmin, which bounds sizes from curvature: down to this sizes go to keep a chord error, or where features
/// or sheets are near.
constexpr double kFinestSize = 0.1;

/// One of four rules, then clamped to [hmin, hmax]. rho is the minimal radius of curvature 1 / max(|k1|, |k2|). [theory
/// of the circle: a chord of length h on a circle of radius rho]
struct SizingRule {
    enum class Kind {
        Proportional,        ///< h = value rho
        RelativeChordError,  ///< value = gap between chord and arc over rho, in (0, 1]: h = 2 rho sqrt(value (2 -
                             ///< value))
        ChordError,          ///< value = gap between chord and arc, unit of length: h = 2 sqrt(value (2 rho - value))
        NormalAngle  ///< value = angle between the normals at the ends of an edge, radians, in (0, pi]: h = 2 rho
                     ///< sin(value / 2)
    };
    Kind kind = Kind::Proportional;
    double value = 0.3;
    double most_turn = std::numbers::pi;  ///< as the value of NormalAngle, beside any kind; pi: unbounded
    double hmin = 0;                      ///< unit of length, >= 0
    double hmax = std::numeric_limits<double>::infinity();  ///< unit of length, > hmin

    /// A size prescribed at a point: its map is lowered to `size` at the nearest vertex of the background. Backgrounds
    /// that are made by a rule have one within `size` of the surface's point that is nearest.
    struct At {
        Eigen::Vector3d point;
        double size;
    };
    std::vector<At> at = {};

    // -- On triangulations only, see control/clearance.hpp --
    /// hmin, or hmax, is a default for the whole surface: connected parts have theirs in proportion to their diagonals,
    /// and clearances lead down to kFinestSize of hmin.
    bool hmin_by_part = false, hmax_by_part = false;
    /// Largest size over the distance between features that face each other, and on curves between corners over their
    /// length; 0: unbounded. A row of triangles between two lines has area-length .97 where its edges along them
    /// are 1.5 times the distance, .87 at twice, .53 at four times.
    double feature_clearance = 1.5;
    double sheet_clearance =
        0;  ///< largest size over the distance to the opposite sheet, through material or void; 0: unbounded

    /// Sizes are at most `size` in the triangles of a label, even below hmin.
    struct Region {
        int label;
        double size;
    };
    std::vector<Region> regions = {};
};

/// @throws std::invalid_argument naming the value that is out of range
void check(const SizingRule& rule);

/// Size for a minimal radius rho >= 0 (may be infinite), clamped.
double size_from_radius(const SizingRule& rule, double rho);

/// The index of the point nearest to another one, the first of several. @pre not empty
std::size_t nearest_point(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& to);

/// Sizes prescribed at points hold at the vertices nearest to them.
void lower_to_prescribed(std::span<const SizingRule::At> prescribed, std::span<const Eigen::Vector3d> points,
                         std::vector<double>& sizes);

}  // namespace gradus
