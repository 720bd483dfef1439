#include "gradus/control/background.hpp"

#include "gradus/surface/locate.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr double kOnSurface = 1e-6;  // distance from its patch, over the diagonal, at which a vertex counts as on it

using Corners = std::array<Eigen::Vector2d, 3>;

// Parameters of each vertex, grouped by vertex.
class ParameterTable {
  public:
    ParameterTable(const TriangleSoup& soup) : first_(soup.points.size() + 1, 0), entries_(soup.parameters.size()) {
        for (const auto& p : soup.parameters) ++first_[p.vertex + 1];
        for (std::size_t v = 0; v + 1 < first_.size(); ++v) first_[v + 1] += first_[v];
        std::vector<int> fill(first_.begin(), first_.end() - 1);
        for (const auto& p : soup.parameters) entries_[fill[p.vertex]++] = p.at;
    }
    std::span<const SurfacePoint> of(int vertex) const {
        return {entries_.data() + first_[vertex], entries_.data() + first_[vertex + 1]};
    }

  private:
    std::vector<int> first_;
    std::vector<SurfacePoint> entries_;
};

// A vertex on a seam or a pole has several places on one patch: take those that lie closest together.
bool corners_from_table(const ParameterTable& table, const Triangle& triangle, int patch, Corners& corners) {
    double least = std::numeric_limits<double>::infinity();
    for (const SurfacePoint& a : table.of(triangle[0]))
        for (const SurfacePoint& b : table.of(triangle[1]))
            for (const SurfacePoint& c : table.of(triangle[2])) {
                if (a.patch != patch || b.patch != patch || c.patch != patch) continue;
                const double spread =
                    (a.uv - b.uv).squaredNorm() + (b.uv - c.uv).squaredNorm() + (c.uv - a.uv).squaredNorm();
                if (spread < least) least = spread, corners = {a.uv, b.uv, c.uv};
            }
    return least < std::numeric_limits<double>::infinity();
}

struct Feet {
    Corners uv;
    std::array<double, 3> distance;
    double largest() const { return std::max({distance[0], distance[1], distance[2]}); }
};

// Feet of the corners of a triangle on a patch, all by descent from the foot of one point, so that they lie together.
Feet descend(const SurfaceModel& model, const std::array<Eigen::Vector3d, 3>& corners, const SurfacePoint& start) {
    Feet feet;
    for (int k = 0; k < 3; ++k) {
        const Projection foot = project_within(model, corners[k], start);
        feet.uv[k] = foot.at.uv;
        feet.distance[k] = foot.distance;
    }
    return feet;
}

}  // namespace

Background background_from_soup(const SurfaceModel& model, const TriangleSoup& soup) {
    Background background{make_mesh(soup.points, soup.triangles), {}, {}};
    const ParameterTable table(soup);
    background.patch.reserve(soup.triangles.size());
    background.uv.reserve(soup.triangles.size());
    std::optional<Locator> sampled;  // made for the first triangle that needs it
    const auto locator = [&]() -> const Locator& { return sampled ? *sampled : sampled.emplace(model); };
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        const Triangle& triangle = soup.triangles[t];
        const Eigen::Vector3d centre =
            (soup.points[triangle[0]] + soup.points[triangle[1]] + soup.points[triangle[2]]) / 3;
        int patch = soup.labels.empty() ? -1 : soup.labels[t] - 1;
        if (patch < 0 || patch >= model.num_patches()) patch = locator().find(centre).at.patch;
        Corners corners;
        if (!corners_from_table(table, triangle, patch, corners)) {
            const std::array<Eigen::Vector3d, 3> points{soup.points[triangle[0]], soup.points[triangle[1]],
                                                        soup.points[triangle[2]]};
            // Around a pole the way from the middle to a corner may be barred by the seam: then come from a corner.
            Feet feet = descend(model, points, locator().find_on(patch, centre).at);
            for (int k = 0; k < 3 && feet.largest() > kOnSurface * model.diagonal(); ++k) {
                const Feet other = descend(model, points, locator().find_on(patch, points[k]).at);
                if (other.largest() < feet.largest()) feet = other;
            }
            for (int k = 0; k < 3; ++k)
                if (feet.distance[k] > kOnSurface * model.diagonal())
                    throw std::invalid_argument("background: vertex " + std::to_string(triangle[k] + 1) +
                                                " is off patch " + std::to_string(patch + 1) + " by " +
                                                std::to_string(feet.distance[k]));
            corners = feet.uv;
        }
        background.patch.push_back(patch);
        background.uv.push_back(corners);
    }
    return background;
}

TriangleSoup soup_from_background(const Background& background) {
    TriangleSoup soup;
    const auto points = points_of(background.mesh);
    soup.points.assign(points.begin(), points.end());
    soup.triangles = triangles_of(background.mesh);
    // Each vertex once per place, in the order of its triangles.
    std::vector<std::vector<SurfacePoint>> places(points.size());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        soup.labels.push_back(background.patch[t] + 1);
        for (int k = 0; k < 3; ++k) {
            const int v = soup.triangles[t][k];
            const SurfacePoint at{background.patch[t], background.uv[t][k]};
            const bool known = std::any_of(places[v].begin(), places[v].end(),
                                           [&](const SurfacePoint& p) { return p.patch == at.patch && p.uv == at.uv; });
            if (!known) places[v].push_back(at);
        }
    }
    for (std::size_t v = 0; v < places.size(); ++v)
        for (const SurfacePoint& at : places[v]) soup.parameters.push_back({static_cast<int>(v), at});
    return soup;
}

}  // namespace gradus
