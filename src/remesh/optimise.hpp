// The schedule of local operations that turns a mesh of about the right density into a good one.
#pragma once

#include "editor.hpp"
#include "gradus/remesh/parametric.hpp"
#include "stage_clock.hpp"

namespace gradus {

struct OptimiseOptions {
    bool fast = false;    // a lighter schedule: no attempts beyond fitting, flips and smoothing
    double goal = 0.90;   // area-length quality asked of the worst triangle
    bool given = false;   // the mesh may have triangles of any shape
    bool fitted = false;  // the mesh has about the sizes asked for
    bool fans = false;    // edges at a vertex that differ by much are as bad as triangles below the goal
    /// Vertices to work at, and around what changes there; new ones count as well. Empty: all.
    std::vector<char> active = {};

    bool is_active(int v) const { return v >= static_cast<int>(active.size()) || active[v]; }
};

struct OptimiseReport {
    int splits = 0, collapses = 0, flips = 0;
    int attempts = 0, kept = 0;              // operations tried for the mean, and those that lowered the energy
    int worst_attempts = 0, worst_kept = 0;  // the same for the worst triangles
    int below_goal = 0;                      // triangles that stayed below the goal
};

void take_report(const OptimiseReport& report, RemeshStatistics& statistics);

/// @returns the number of triangles predicted
/// @throws std::length_error where there are more than allowed
/// @throws std::invalid_argument where sizes are lost in the rounding of coordinates
template <class M>
double check_estimate(const InterpolatedField<M>& control, const RemeshOptions& options);

template <class M>
OptimiseReport optimise(EditorOf<M>& editor, const OptimiseOptions& options, StageClock& clock);

/// Only the search for better worst triangles, by operations that the editor's guard lets pass. @param active  as in
/// OptimiseOptions
template <class M>
OptimiseReport polish(EditorOf<M>& editor, double goal, std::vector<char> active, StageClock& clock);

}  // namespace gradus
