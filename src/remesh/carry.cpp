#include "gradus/remesh/carry.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "gradus/mesh/closest.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kOnSide =
    1e-9;  // a barycentric coordinate below this is rounding: the place is on the side, or at the corners, opposite
constexpr std::size_t kGrain = 512;

using Weights = std::array<double, 3>;

Weights weights_of(const SurfacePoint& at) { return {1 - at.uv.x() - at.uv.y(), at.uv.x(), at.uv.y()}; }

void check_places(const Triangulation& surface, const SurfaceMesh& mesh) {
    if (mesh.places.size() != mesh.points.size())
        throw std::invalid_argument("carry: " + std::to_string(mesh.places.size()) + " places for " +
                                    std::to_string(mesh.points.size()) + " vertices");
    const auto triangles = static_cast<int>(surface.soup().triangles.size());
    for (std::size_t v = 0; v < mesh.places.size(); ++v)
        if (const SurfacePoint& at = mesh.places[v]; at.patch < 0 || at.patch >= triangles || !at.uv.allFinite())
            throw std::invalid_argument("carry: vertex " + std::to_string(v) + " is on triangle " +
                                        std::to_string(at.patch) + " of " + std::to_string(triangles));
}

void check_field(const Field& field, std::size_t count) {
    if (field.components < 1 || field.values.size() != count * static_cast<std::size_t>(field.components))
        throw std::invalid_argument("carry: field '" + field.name + "' has " + std::to_string(field.values.size()) +
                                    " numbers for " + std::to_string(count) + " times " +
                                    std::to_string(field.components) + " components");
}

double interpolated(const Weights& w, const Weights& f) {
    double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0, from_first = 0;
    int first = -1;
    for (int k = 0; k < 3; ++k) {
        if (!(w[k] > 0) || (w[k] < kOnSide && !std::isfinite(f[k]))) continue;
        if (std::isnan(f[k])) return f[k];
        if (first < 0) first = k;
        low = std::min(low, f[k]), high = std::max(high, f[k]);
        sum += w[k] * f[k];
        from_first += w[k] * (f[k] - f[first]);
    }
    // From one value on, so that equal ones stay what they are.
    const double value = f[first] + from_first;
    return std::isfinite(value) ? std::clamp(value, low, high) : sum;
}

// Walks on the triangulation from triangle to triangle.
class Walk {
  public:
    explicit Walk(const Triangulation& surface) : mesh_(surface.mesh()), points_(surface.soup().points) {}

    // The triangle under the middle of one of the mesh, from the places of its corners.
    int under(const Vector3d& middle, const std::array<SurfacePoint, 3>& corners) const {
        // What is off the features is on one side of them.
        for (const SurfacePoint& at : corners)
            if (!on_feature(at)) return end(at.patch, middle).triangle;
        Reached best{-1, std::numeric_limits<double>::infinity()};
        for (const SurfacePoint& at : corners)
            for_each_at(at, [&](int t) {
                const Reached reached = end(t, middle);
                if (reached.distance < best.distance ||
                    (reached.distance == best.distance && reached.triangle < best.triangle))
                    best = reached;
            });
        return best.triangle;
    }

  private:
    struct Reached {
        int triangle;
        double distance;
    };

    double distance(int t, const Vector3d& p) const {
        const Triangle v = mesh_.triangle(t);
        return (closest_point(p, points_[v[0]], points_[v[1]], points_[v[2]]) - p).norm();
    }

    Reached end(int t, const Vector3d& p) const {
        // Ends, as distances fall and triangles are finitely many.
        for (Reached here{t, distance(t, p)};;) {
            Reached next = here;
            for_each_beside(here.triangle, [&](int other) {
                if (const double d = distance(other, p); d < next.distance) next = {other, d};
            });
            if (next.triangle == here.triangle) return here;
            here = next;
        }
    }

    // Triangles that share a corner and are reached around it without crossing a feature.
    template <class Use>
    void for_each_beside(int t, const Use& use) const {
        for (int start = 3 * t; start < 3 * t + 3; ++start) {
            int h = start;
            while (mesh_.tag(Connectivity::prev(h)) < 0 && (h = mesh_.rotate(h)) != Connectivity::kNone && h != start)
                use(h / 3);
            if (h == start && mesh_.tag(Connectivity::prev(h)) < 0) continue;  // all around
            for (h = start; mesh_.tag(h) < 0 && mesh_.twin(h) != Connectivity::kNone &&
                            (h = Connectivity::next(mesh_.twin(h))) != start;)
                use(h / 3);
        }
    }

    // The corner or else the side of its triangle that a place is on, as a half-edge from it or along it.
    struct Spot {
        int corner = -1, side = -1;
    };
    static Spot spot_of(const SurfacePoint& at) {
        const Weights w = weights_of(at);
        Spot spot;
        for (int k = 0; k < 3; ++k) {
            if (w[(k + 1) % 3] < kOnSide && w[(k + 2) % 3] < kOnSide) spot.corner = 3 * at.patch + k;
            if (w[(k + 2) % 3] < kOnSide) spot.side = 3 * at.patch + k;
        }
        return spot;
    }

    bool on_feature(const SurfacePoint& at) const {
        const Spot spot = spot_of(at);
        if (spot.corner < 0) return spot.side >= 0 && mesh_.tag(spot.side) >= 0;
        bool found = false;
        mesh_.for_each_outgoing(mesh_.origin(spot.corner), [&](int h) {
            found = found || mesh_.tag(h) >= 0 || mesh_.tag(Connectivity::prev(h)) >= 0;
        });
        return found;
    }

    // Triangles that have a place, on all sides of features.
    template <class Use>
    void for_each_at(const SurfacePoint& at, const Use& use) const {
        const Spot spot = spot_of(at);
        if (spot.corner >= 0) return mesh_.for_each_outgoing(mesh_.origin(spot.corner), [&](int h) { use(h / 3); });
        use(at.patch);
        if (spot.side >= 0 && mesh_.twin(spot.side) != Connectivity::kNone) use(mesh_.twin(spot.side) / 3);
    }

    const Connectivity& mesh_;
    std::span<const Vector3d> points_;
};

}  // namespace

std::vector<Field> carry_point_fields(const Triangulation& surface, std::span<const Field> fields,
                                      const SurfaceMesh& mesh) {
    check_places(surface, mesh);
    std::vector<Field> carried;
    for (const Field& field : fields) {
        check_field(field, surface.soup().points.size());
        const auto n = static_cast<std::size_t>(field.components);
        Field& to = carried.emplace_back(Field{field.name, field.components, {}, field.integer});
        to.values.reserve(n * mesh.places.size());
        for (const SurfacePoint& at : mesh.places) {
            const Weights w = weights_of(at);
            const Triangle& v = surface.soup().triangles[at.patch];
            const auto value = [&](int k, std::size_t i) {
                return field.values[n * static_cast<std::size_t>(v[k]) + i];
            };
            for (std::size_t i = 0; i < n; ++i) {
                const double x = interpolated(w, {value(0, i), value(1, i), value(2, i)});
                to.values.push_back(field.integer ? std::nearbyint(x) : x);
            }
        }
    }
    return carried;
}

std::vector<int> triangles_of_input(const Triangulation& surface, const SurfaceMesh& mesh) {
    check_places(surface, mesh);
    const Walk walk(surface);
    std::vector<int> under(mesh.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, under.size(), kGrain), [&](const auto& range) {
        for (std::size_t t = range.begin(); t < range.end(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            const Vector3d middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
            under[t] = walk.under(middle, {mesh.places[a], mesh.places[b], mesh.places[c]});
        }
    });
    return under;
}

std::vector<Field> carry_cell_fields(const Triangulation& surface, std::span<const Field> fields,
                                     const SurfaceMesh& mesh) {
    if (fields.empty()) return {};
    const std::vector<int> under = triangles_of_input(surface, mesh);
    std::vector<Field> carried;
    for (const Field& field : fields) {
        check_field(field, surface.soup().triangles.size());
        const auto n = static_cast<std::size_t>(field.components);
        Field& to = carried.emplace_back(Field{field.name, field.components, {}, field.integer});
        to.values.reserve(n * under.size());
        for (const int t : under)
            for (std::size_t i = 0; i < n; ++i) to.values.push_back(field.values[n * static_cast<std::size_t>(t) + i]);
    }
    return carried;
}

}  // namespace gradus
