/// Places where sides of a model meet only in part, and so were not glued.
#pragma once

#include <vector>

#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// A vertex of the boundary that lies on a boundary curve it is no end of.
struct TJunction {
    int vertex = -1;
    int curve = -1;
    double t = 0;         ///< parameter of the closest point of the curve
    double distance = 0;  ///< to that point
};

/// Boundary vertices within a distance of boundary curves they do not end (vertices at a place where the curve ends
/// count as its end), by vertex, then curve. A conforming mesh cannot be had across them: the patches must be split
/// there.
/// @param tolerance  largest distance, relative to the diagonal of the model, > 0
std::vector<TJunction> find_t_junctions(const SurfaceModel& model, double tolerance = 1e-6);

}  // namespace gradus
