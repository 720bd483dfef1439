#include "gradus/remesh/mesh_triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

#include "gradus/gradation/hold.hpp"
#include "gradus/remesh/triangulation_for.hpp"

namespace gradus {

namespace {

constexpr int kMostAttempts = 6;  // to mend a mesh with more features
// With at most so many faults, what was hard on the way is left alone; with more than the second number it is not for
// want of features.
constexpr std::size_t kFewFaults = 4, kMostFaults = 20'000;

double smallest_part(const Triangulation& surface) {
    return *std::min_element(surface.part_share().begin(), surface.part_share().end());
}

std::vector<std::pair<SizingRule::At, double>> moved_far(const SizingRule& rule,
                                                         std::span<const Eigen::Vector3d> background) {
    std::vector<std::pair<SizingRule::At, double>> moved;
    for (const SizingRule::At& at : rule.at) {
        const double distance = (background[nearest_point(background, at.point)] - at.point).norm();
        if (distance > at.size) moved.emplace_back(at, distance);
    }
    return moved;
}

void require_reached(std::span<const double> sizes) {
    const auto unset = std::count_if(sizes.begin(), sizes.end(), [](double h) { return !std::isfinite(h); });
    if (unset > 0)
        throw std::invalid_argument(std::to_string(unset) +
                                    " vertices have no size, in parts of the surface where no vertex has one");
}

// The stages from a triangulation to its mesh, and again with more features.
class Mesher {
  public:
    Mesher(const SizingRule& rule, const TriangulationMeshOptions& options) : rule_(rule), options_(options) {}

    MeshedTriangulation run(std::shared_ptr<const Triangulation> surface) {
        TriangulationMesh mesh = mesh_once(*surface);
        return mend_by_features({std::move(surface), std::move(mesh)});
    }

  private:
    bool has_chord_error() const { return rule_.kind == SizingRule::Kind::ChordError; }

    void stage(std::string_view name, const std::function<void()>& work) const {
        options_.run_stage ? options_.run_stage(name, work) : work();
    }

    TriangulationBackground background_of(const Triangulation& surface) const {
        if (options_.sizes) return options_.sizes(surface);
        return make_background(surface, has_chord_error() ? rule_within(rule_.value, rule_) : rule_,
                               static_cast<int>(options_.remesh.max_triangles));
    }

    TriangulationMesh mesh_once(const Triangulation& surface) const {
        TriangulationMesh mesh;
        if (has_chord_error()) mesh.chord_error = rule_.value;
        if (options_.keeps_hmin) mesh.least_size = rule_.hmin;
        TriangulationBackground map;
        stage("background", [&] { map = background_of(surface); });
        mesh.background_vertices = map.sizes.size();
        mesh.moved = moved_far(rule_, points_of(map.background.mesh));
        if (options_.gradation)
            stage("gradation", [&] { mesh.gradation = grade(map.background.mesh, map.sizes, *options_.gradation); });
        if (options_.gradation && options_.sizes) require_reached(map.sizes);
        raise_to_held(map.background.mesh, frozen_edge_lengths(surface.soup().points, surface.mesh(), surface.frozen()),
                      kHoldSlope, map.sizes);
        const double hmin = options_.keeps_hmin ? rule_.hmin : kFinestSize * rule_.hmin * smallest_part(surface);
        ChordErrorResult made;
        stage("meshing", [&] {
            made = remesh_within(surface, std::move(map),
                                 mesh.chord_error.value_or(std::numeric_limits<double>::infinity()),
                                 {.gradation = options_.gradation,
                                  .hmin = hmin,
                                  .prescribed = rule_.at,
                                  .remesh = options_.remesh,
                                  .on_check = options_.on_check});
        });
        if (made.map)
            measure_graded(make_mesh(made.map->points, made.map->triangles), made.map->sizes, *options_.gradation,
                           *mesh.gradation);
        mesh.result = std::move(made.result);
        if (has_chord_error())
            mesh.deviation = made.deviation;
        else
            stage("distance", [&] { mesh.deviation = measure_deviation(surface, mesh.result.mesh); });
        mesh.refinements = made.lowerings;
        mesh.kept = made.kept;
        mesh.faults = std::move(made.faults);
        mesh.stubborn = std::move(made.stubborn);
        mesh.contacts = std::move(made.contacts);
        return mesh;
    }

    // Null where the surface has no more features with all folds near these places as such.
    std::unique_ptr<Triangulation> with_features_at(std::span<const Eigen::Vector3d> places,
                                                    const Triangulation& surface) const {
        auto more = triangulation_for(surface.soup(), rule_, options_.triangulation, places);
        const auto number = [](const Features& features) {
            return std::pair(features.edges().size(), std::count(features.corner.begin(), features.corner.end(), 1));
        };
        return number(more->features()) == number(surface.features()) ? nullptr : std::move(more);
    }

    MeshedTriangulation mend_by_features(MeshedTriangulation best) const {
        const auto what_is_wrong = [](const TriangulationMesh& of) {
            return std::tuple(!of.kept, of.contacts.count, of.deviation.bound());
        };
        if (best.mesh.kept && best.mesh.contacts.count == 0) return best;
        MeshedTriangulation last = best;
        std::vector<Eigen::Vector3d> places;
        for (int attempt = 1; (!last.mesh.kept || last.mesh.contacts.count > 0) && attempt <= kMostAttempts;
             ++attempt) {
            const TriangulationMesh& mesh = last.mesh;
            places.insert(places.end(), mesh.faults.begin(), mesh.faults.end());
            for (const NewContact& contact : mesh.contacts.listed) places.push_back(contact.point);
            if (attempt > 1 || mesh.faults.size() > kFewFaults)
                places.insert(places.end(), mesh.stubborn.begin(), mesh.stubborn.end());
            if (places.size() > kMostFaults) break;
            std::shared_ptr<const Triangulation> more;
            stage("features", [&] { more = with_features_at(places, *last.surface); });
            if (!more) break;
            try {
                last.mesh = mesh_once(*more);
            } catch (const std::length_error&) {
                break;  // more triangles than there may be
            }
            last.surface = std::move(more);
            if (what_is_wrong(last.mesh) < what_is_wrong(best.mesh)) best = last;
        }
        return best;
    }

    const SizingRule& rule_;
    const TriangulationMeshOptions& options_;
};

}  // namespace

MeshedTriangulation mesh_triangulation(std::shared_ptr<const Triangulation> surface, const SizingRule& rule,
                                       const TriangulationMeshOptions& options) {
    return Mesher(rule, options).run(std::move(surface));
}

}  // namespace gradus
