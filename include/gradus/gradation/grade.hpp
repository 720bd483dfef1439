/// One entry to all ways of grading a size map.
#pragma once

#include "gradus/gradation/isotropic.hpp"
#include "gradus/gradation/measures.hpp"

#include <optional>
#include <span>
#include <vector>

namespace gradus {

enum class GradationMethod {
    Full,      ///< by edges and by triangles: limit_h_shock / limit_h_variation, then limit_gradient
    Exact,     ///< by edges: the largest map that meets the bounds there, with its certificate
    Gradient,  ///< by distance on the surface: march_gradient
    Paper      ///< the paper's iteration over edges, for comparison
};

struct GradationOptions {
    GradationMethod method = GradationMethod::Full;
    /// Largest H-shock beta > 1. It is the growth rate between successive elements: elements of a unit mesh have the
    /// metric length 1, and the H-shock is the ratio of sizes over that length. So a growth rate G is a shock of G.
    std::optional<double> shock = {};
    std::optional<double> variation = {};  ///< largest H-variation > 0; both bounds hold where both are given
    std::vector<int> required = {};        ///< vertices whose size may not be lowered (not for Paper)
};

struct GradationResult {
    int lowered = 0;            ///< vertices whose size went down
    double largest_factor = 1;  ///< largest size before / after; infinite where an unset size was set
    bool converged = true;      ///< false: a limiter stopped at its largest number of visits or sweeps
    bool met = false;           ///< the result, measured, meets what the method promises (bounds and tolerances below)
    double gradient_bound = 0;  ///< bound used on triangles: ln(shock), variation, or the smaller of the two
    int steep_triangles = 0;    ///< triangles above gradient_bound (1 + 1e-9), whether or not the method bounds them
    int coarse_edges = 0;       ///< count_coarse_edges of the result, where a shock is given
    Certificate certificate;    ///< Exact with one bound only, else empty
    std::vector<RequiredConflict>
        conflicts;                  ///< required sizes that the bound on edges would have lowered (Full, Exact)
    GradationReport before, after;  ///< measured
};

/// Lowers a size map until it changes nowhere faster than asked, and measures the result.
/// `met` for Full: shock <= beta (1 + 1e-9), variation <= its bound (1 + 1e-9) and the gradient of every triangle
/// <= gradient_bound (1 + 1e-6); Exact and Paper: the bounds on edges; Gradient: converged, as the surface between
/// vertices cannot be measured on edges.
/// @param size  one size h > 0 per vertex, infinite where it is not set; lowered in place
/// @throws std::invalid_argument if no bound is given, shock <= 1, variation <= 0, a size is not positive, a required
/// size is
///         unset, or sizes are required of Paper
GradationResult grade(const TriMesh& mesh, std::span<double> size, const GradationOptions& options);

/// Bound on the gradient of sizes that the options' bounds on edges come from: ln(shock), variation, or the smaller of
/// the two.
/// @throws std::invalid_argument as grade
double gradient_bound(const GradationOptions& options);

/// Measures a map that was graded elsewhere: `after`, `met` and the counts of a result.
void measure_graded(const TriMesh& mesh, std::span<const double> size, const GradationOptions& options,
                    GradationResult& result);

}  // namespace gradus
