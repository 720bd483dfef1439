/// Everything that is measured on a mesh that came out, in one struct, and as text for people.
#pragma once

#include "gradus/quality/distance.hpp"
#include "gradus/quality/edges.hpp"
#include "gradus/quality/offenders.hpp"
#include "gradus/quality/realised.hpp"
#include "gradus/quality/reference.hpp"
#include "gradus/quality/shape.hpp"
#include "gradus/quality/topology.hpp"

#include <optional>
#include <string>

namespace gradus {

/// Wall-clock time of a step, for the report.
struct StageTime {
    std::string name;
    double seconds = 0;
};

struct MeshReport {
    TopologyReport topology;
    ShapeReport shape;
    RealisedGradation gradation;
    OffenderReport offenders;
    std::optional<EdgeReport> edges;         ///< where a size map was given
    std::optional<DistanceReport> distance;  ///< where a model or a reference was given
    std::optional<NormalReport> normals;
    std::optional<ReferenceReport> reference;  ///< where a reference was given
    std::vector<StageTime> stages;             ///< filled by the caller
};

/// What a mesh is measured against; what is not given is not measured.
struct MeasureOptions {
    std::span<const double>
        sizes{};       ///< one per vertex: lengths by geometric interpolation between them, causes of offenders
    SizeQuery size{};  ///< size map in space, taken before `sizes`
    std::span<const int> size_hints{};           ///< see metric_lengths
    const KnownFeatures* features = nullptr;     ///< curves and corners that the mesh keeps; null: found by angle
    const RequiredElements* required = nullptr;  ///< what it was not to touch
    const SurfaceModel* model = nullptr;
    std::span<const SurfacePoint> places{};  ///< one per vertex, with a model
    std::span<const int> patches{};          ///< one per triangle, may be empty
    const Reference* reference = nullptr;    ///< a triangulated surface, in place of a model
    std::size_t worst = 10;                  ///< how many offenders of each kind to list
};

/// @throws std::invalid_argument as edges_of, metric_lengths, find_offenders, measure_distance and Reference do
MeshReport measure(const MeshView& mesh, const MeasureOptions& options = {});

/// Aligned tables and histograms, at most 110 columns.
std::string to_text(const MeshReport& report);

}  // namespace gradus
