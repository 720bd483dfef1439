#include "gradus/remesh/patch_chord_error.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr double kShareOfFacets = 1.0 / 16;  // of the chord error: gaps of the facets that stand for the surface
constexpr double kUnseen = 2;                // what gaps may be over what is seen of them
constexpr int kMostLowerings = 8, kMostOfFactors = 20;
// Factors on the sizes of a metric. Elements are not as they are in it: they begin somewhat smaller.
constexpr double kFirstOfFactors = 0.72, kLeastFactor = 0.1;
constexpr double kMargin = 0.9;  // on sizes that are lowered, as the distance goes with their square

// The triangles of the map under what is too far, lowered by how much it is.
class Lowering {
  public:
    Lowering(const SizedBackground& map, const ControlSpace& control, double hmin)
        : map_(map), control_(control), hmin_(hmin), triangles_(triangles_of(map.background.mesh)), sizes_(map.sizes) {}

    void at(const SurfacePoint& place, double distance, double allowed) {
        const double factor = kMargin * std::sqrt(allowed / distance);
        for (const int v : triangles_[control_.locate(place)]) {
            const double lowered = std::max(hmin_, factor * map_.sizes[v]);
            if (lowered >= sizes_[v]) continue;
            sizes_[v] = lowered;
            any_ = true;
        }
    }
    bool any() const { return any_; }
    std::vector<double> take() { return std::move(sizes_); }

  private:
    const SizedBackground& map_;
    const ControlSpace& control_;
    double hmin_;
    std::vector<Triangle> triangles_;
    std::vector<double> sizes_;
    bool any_ = false;
};

SurfacePoint middle_of(const Background& facets, int t) {
    return {facets.patch[t], (facets.uv[t][0] + facets.uv[t][1] + facets.uv[t][2]) / 3};
}

}  // namespace

namespace {

// The loop of meshing, measuring and lowering. @param least  of the sizes
// @param mesh_for  makes the mesh of a map
template <class MeshFor>
PatchChordErrorResult mesh_until_within(const SurfaceModel& model, SizedBackground& map, double chord_error,
                                        const PatchChordErrorOptions& options, double least, int most_lowerings,
                                        const MeshFor& mesh_for) {
    if (!(chord_error > 0))
        throw std::invalid_argument("remesh_within: chord error is " + std::to_string(chord_error) + ", not above 0");
    PatchChordErrorResult made;
    const FacetedSurface faceted =
        facets_within(model, map.background, kShareOfFacets * chord_error, options.most_facets);
    made.facets = kUnseen * faceted.gap;
    const double allowed = chord_error - made.facets;
    const std::vector<Triangle> facets = triangles_of(faceted.facets.mesh);
    const MeshView surface{points_of(faceted.facets.mesh), facets};
    const DistanceTarget to_surface(surface);
    for (;; ++made.lowerings) {
        const ControlSpace control(map.background, map.sizes);
        made.result = mesh_for(control);
        const SurfaceMesh& mesh = made.result.mesh;
        const MeshView view{mesh.points, mesh.triangles};
        made.deviation = {to_surface.measure_from(view, {.limit = allowed}),
                          DistanceTarget(view).measure_from(surface, {.limit = allowed})};
        made.kept = made.deviation.bound() <= allowed;
        if (made.kept || made.lowerings == most_lowerings) break;
        Lowering lowering(map, control, least);
        // Under the place, and at the corners of the triangle that is there.
        const auto lower = [&](int triangle, int facet, double distance) {
            if (facet >= 0) lowering.at(middle_of(faceted.facets, facet), distance, allowed);
            if (triangle < 0) return;
            for (const int v : mesh.triangles[triangle]) lowering.at(mesh.places[v], distance, allowed);
        };
        for (const TooFar& far : made.deviation.from_mesh.beyond) lower(far.triangle, far.nearest, far.distance);
        for (const TooFar& far : made.deviation.from_reference.beyond) lower(far.nearest, far.triangle, far.distance);
        if (!lowering.any()) break;
        map.sizes = lowering.take();
        if (options.gradation) grade(map.background.mesh, map.sizes, *options.gradation);
    }
    for (OneSidedDistance* side : {&made.deviation.from_mesh, &made.deviation.from_reference})
        side->bound += made.facets;
    return made;
}

}  // namespace

PatchChordErrorResult remesh_within(const SurfaceModel& model, SizedBackground& map, double chord_error,
                                    const PatchChordErrorOptions& options) {
    return mesh_until_within(model, map, chord_error, options, options.hmin, kMostLowerings,
                             [&](const ControlSpace& control) { return remesh(model, control, options.remesh); });
}

PatchChordErrorResult stretch_within(const SurfaceModel& model, const SizedBackground& map, double chord_error,
                                     const StretchOptions& options) {
    const ControlSpace sizes(map.background, map.sizes);
    // What is lowered are factors on the sizes of the metric, whose change is bounded too.
    SizedBackground factors = map;
    std::fill(factors.sizes.begin(), factors.sizes.end(), kFirstOfFactors);
    return mesh_until_within(model, factors, chord_error,
                             {.remesh = options.remesh, .most_facets = options.most_facets}, kLeastFactor,
                             kMostOfFactors, [&](const ControlSpace& factor) {
                                 const auto metric = [&](const SurfacePoint& at) {
                                     const double f = factor.size(at);
                                     return chord_error_metric(model, at, f * f * chord_error, options.bounds);
                                 };
                                 return remesh(model, sizes, metric, options.gradation, options.remesh);
                             });
}

}  // namespace gradus
