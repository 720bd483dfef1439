// The vertices that a mesh of patches begins with.
#pragma once

#include "../control/patch_meshes.hpp"
#include "editor.hpp"
#include "gradus/remesh/support.hpp"

#include <vector>

namespace gradus {

// Corners are fixed, what lies on features slides, all else is free; each has the normal and the lean of its foot.
// @returns one vertex per number of the assembly
std::vector<Vertex> place_vertices(const SurfaceModel& model, const PatchSupport& support, const ControlSpace& control,
                                   const CutCurves& curves, const PatchMeshes& assembly);

}  // namespace gradus
