// The division of feature curves into edges, while the triangles on both sides are there.
#pragma once

#include "optimise.hpp"

namespace gradus {

/// Divides the runs of feature curves between vertices that do not slide, where the mesh is worked at, into edges of
/// equal metric length, as many as come nearest to unit: halving what is too long leaves edges that are too short and
/// that no single collapse mends. Runs whose triangles bar it keep more edges or fewer. Counts what it does in the
/// report.
template <class M>
void divide_curves(EditorOf<M>& editor, const OptimiseOptions& options, OptimiseReport& report);

}  // namespace gradus
