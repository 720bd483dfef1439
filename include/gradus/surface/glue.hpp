/// Rectangular patches joined where their sides coincide.
#pragma once

#include <memory>
#include <vector>

#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// Glues patches whose domains are rectangles. Sides are glued where their curves coincide, in either direction, never
/// where only corners do: parts that touch or cross stay apart. A side may meet another side of its own patch (a seam).
/// Closed sides must start at the same point. Sides that coincide only in part (T-junctions) stay boundaries. Of sides
/// with the same control points both uses have the same positions to the bit.
///
/// The loop of a patch is its sides v = min, u = max, v = max, u = min, in this order.
/// @throws std::invalid_argument as SurfaceModel, and naming the curve that three or more sides share
SurfaceModel glue(std::vector<std::unique_ptr<const ParametricSurface>> patches, const ModelOptions& options = {});

}  // namespace gradus
