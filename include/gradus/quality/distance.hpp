/// How far a mesh is from the exact surface of patches it stands for, and how its triangles lean against it.
#pragma once

#include "gradus/quality/mesh_edges.hpp"
#include "gradus/quality/statistics.hpp"
#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// A mesh whose vertices know their places on the surface.
struct PlacedMesh {
    MeshView mesh;
    std::span<const SurfacePoint> places;  ///< one per vertex
    std::span<const int> patches;          ///< one per triangle: the patch under (most of) it; may be empty
};

/// Distances relative to the diagonal of the model.
struct DistanceReport {
    double diagonal = 0;  ///< unit of length
    Summary vertices;     ///< |p - S(u, v)| at used vertices
    Summary midpoints;    ///< of edges, to the closest point found
    Summary centroids;    ///< of triangles
    std::vector<Offender> worst_vertices, worst_triangles;
    std::vector<EdgeOffender> worst_edges;
};

/// Angles between the normal of a triangle and those of the surface at its corners, degrees in [0, 180].
struct NormalReport {
    Summary angle;            ///< largest of the three, over triangles
    std::size_t over_45 = 0;  ///< triangles with an angle above 45 degrees
    std::size_t over_60 = 0;
    std::size_t without_normal = 0;  ///< triangles of no area, which are left out
    std::vector<Offender> worst;     ///< triangles of the largest angle
};

struct DistanceOptions {
    std::size_t worst = 10;  ///< how many of each kind to list
};

/// Closest points are sought from the interpolated parameters of the corners where they share a patch, else from each
/// corner, across shared curves; every distance is that of a point of the surface, so none is understated.
/// @param edges  edges_of(placed.mesh)
/// @throws std::invalid_argument if there is not one place per vertex, or a used one names no patch of the model
DistanceReport measure_distance(const SurfaceModel& model, const PlacedMesh& placed, const MeshEdges& edges,
                                const DistanceOptions& options = {});

/// On a crease a corner takes the normal of the patch of its triangle. @throws as above
NormalReport measure_normals(const SurfaceModel& model, const PlacedMesh& placed, const DistanceOptions& options = {});

}  // namespace gradus
