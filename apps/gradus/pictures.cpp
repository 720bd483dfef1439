#include "pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "gradus/gradation/measures.hpp"
#include "gradus/mesh/parts.hpp"

namespace gradus::app {

namespace {

constexpr double kEnlarged = 0.13;  // width of an enlargement, fraction of the extent of the mesh
constexpr int kCandidates = 40;     // places compared for each enlargement
constexpr double kFacing = 0.7;     // least cosine between the view and the normal of an enlarged place
constexpr double kApart = 0.6;      // least distance of two enlarged places on one part, the same

// What lies in a plane of constant z is seen from above.
bool is_level(std::span<const Eigen::Vector3d> points) {
    return std::all_of(points.begin(), points.end(),
                       [&](const Eigen::Vector3d& p) { return p.z() == points.front().z(); });
}

Camera usual_view(std::span<const Eigen::Vector3d> points) {
    Camera camera;
    if (is_level(points)) camera.direction = {0, 0, 1}, camera.up = {0, 1, 0};
    return camera;
}

double extent_of(const SurfaceMesh& mesh) {
    Eigen::Vector3d low = mesh.points.front(), high = low;
    for (const Eigen::Vector3d& p : mesh.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
    return (high - low).norm();
}

std::vector<Eigen::Vector3d> normals_of(const SurfaceMesh& mesh) {
    std::vector<Eigen::Vector3d> normals(mesh.points.size(), Eigen::Vector3d::Zero());
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3d n = (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]);
        for (const int v : t) normals[v] += n;
    }
    for (Eigen::Vector3d& n : normals) n.normalize();
    return normals;
}

// Whether a ray from `from` meets a triangle. [Moeller, Trumbore 1997]
bool meets(const Eigen::Vector3d& from, const Eigen::Vector3d& way, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
           const Eigen::Vector3d& c) {
    const Eigen::Vector3d e1 = b - a, e2 = c - a, p = way.cross(e2), s = from - a, q = s.cross(e1);
    const double det = e1.dot(p);
    if (std::abs(det) < 1e-300) return false;
    const double u = s.dot(p) / det, v = way.dot(q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && e2.dot(q) / det > 0;
}

bool is_seen(const SurfaceMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& way) {
    return std::none_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
        return meets(from, way, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
    });
}

struct Place {
    int vertex;
    double ratio;  // of the largest and the smallest size around it
};

// The finest vertex of each cube of side `reach`, those first around which sizes differ most: by the ratio of sizes in
// the cube and its neighbours, of the same part of the mesh.
std::vector<Place> abrupt_places(const SurfaceMesh& mesh, double reach) {
    struct Cube {
        int finest = -1;
        double low = 0, high = 0;
    };
    using Key = std::array<int, 4>;  // place, and part
    const std::vector<int> part = connected_parts(mesh.points.size(), mesh.triangles);
    std::map<Key, Cube> cubes;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const Eigen::Vector3d cell = (mesh.points[v] / reach).array().floor();
        Cube& cube =
            cubes[{static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z()), part[v]}];
        const double h = mesh.sizes[v];
        if (cube.finest < 0 || h < cube.low) cube.low = h, cube.finest = static_cast<int>(v);
        cube.high = std::max(cube.high, h);
    }
    std::vector<Place> places;
    for (const auto& [key, cube] : cubes) {
        double high = 0;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k)
                    if (const auto near = cubes.find({key[0] + i, key[1] + j, key[2] + k, key[3]}); near != cubes.end())
                        high = std::max(high, near->second.high);
        places.push_back({cube.finest, high / cube.low});
    }
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return a.ratio != b.ratio ? a.ratio > b.ratio : a.vertex < b.vertex;
    });
    return places;
}

// Looks along the normal, rather from above and from the side of the usual view; nothing if the place is hidden from
// everywhere.
std::optional<Eigen::Vector3d> view_of(const SurfaceMesh& mesh, const Eigen::Vector3d& place,
                                       const Eigen::Vector3d& normal, double extent) {
    if (is_level(mesh.points)) return usual_view(mesh.points).direction;
    std::vector<Eigen::Vector3d> ways;
    for (const double height : {0.35, 0.8, 0.0, 1.6, -0.5})
        for (int k = 0; k < 16; ++k) {
            const double angle = -1.0 + k * std::numbers::pi / 8;
            ways.push_back(Eigen::Vector3d(std::cos(angle), std::sin(angle), height).normalized());
        }
    const Eigen::Vector3d usual = Camera{}.direction.normalized();
    std::stable_sort(ways.begin(), ways.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        return a.dot(normal) + 0.3 * a.dot(usual) > b.dot(normal) + 0.3 * b.dot(usual);
    });
    const Eigen::Vector3d from = place + 1e-4 * extent * normal;
    for (const Eigen::Vector3d& way : ways)
        if (way.dot(normal) > kFacing && is_seen(mesh, from, way)) return way;
    return std::nullopt;
}

// Where a view of that width is filled best: the place moved towards the middle of the surface around it that faces the
// eye, but kept in the picture.
Eigen::Vector3d filled_target(const SurfaceMesh& mesh, const Eigen::Vector3d& place, const Eigen::Vector3d& direction,
                              double width) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double area = 0;
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        const Eigen::Vector3d offset = (a + b + c) / 3 - place, across = offset - offset.dot(direction) * direction;
        const double facing = (b - a).cross(c - a).dot(direction);
        if (facing <= 0 || across.norm() > width / 2 || std::abs(offset.dot(direction)) > width) continue;
        sum += facing * across;
        area += facing;
    }
    if (!(area > 0)) return place;
    Eigen::Vector3d shift = sum / area;
    if (shift.norm() > width / 5) shift *= width / 5 / shift.norm();
    return place + shift;
}

}  // namespace

std::vector<Camera> enlargements(const SurfaceMesh& mesh, int count) {
    const double extent = extent_of(mesh);
    const std::vector<Eigen::Vector3d> normals = normals_of(mesh);
    const std::vector<int> part = connected_parts(mesh.points.size(), mesh.triangles);
    const std::vector<Place> places = abrupt_places(mesh, kEnlarged / 2 * extent);
    const Eigen::Vector3d usual = Camera{}.direction.normalized();

    std::vector<Camera> cameras;
    std::vector<int> shown;
    while (static_cast<int>(cameras.size()) < count) {
        const auto near = [&](int v) {
            return std::any_of(shown.begin(), shown.end(), [&](int w) {
                return part[w] == part[v] && (mesh.points[w] - mesh.points[v]).norm() < kApart * extent;
            });
        };
        // Of the most abrupt places the one that can best be seen from the usual side.
        int best = -1, looked_at = 0;
        double highest = 0;
        Eigen::Vector3d direction;
        for (const Place& place : places) {
            if (near(place.vertex)) continue;
            if (++looked_at > kCandidates) break;
            const auto way = view_of(mesh, mesh.points[place.vertex], normals[place.vertex], extent);
            if (!way) continue;
            const double score = std::log(place.ratio) * (1 + way->dot(usual));
            if (score > highest) highest = score, best = place.vertex, direction = *way;
        }
        if (best < 0) break;
        shown.push_back(best);
        cameras.push_back({.direction = direction,
                           .up = usual_view(mesh.points).up,
                           .target = filled_target(mesh, mesh.points[best], direction, kEnlarged * extent),
                           .width = kEnlarged * extent});
    }
    return cameras;
}

Image draw(const SurfaceMesh& mesh, const Camera& camera) {
    return render({.points = mesh.points, .triangles = mesh.triangles, .features = mesh.features}, camera);
}

Image draw(const SizedTriangles& map, Quantity quantity, const std::optional<Range>& range) {
    std::vector<double> shocks;
    if (quantity == Quantity::Shock) shocks = vertex_shocks(make_mesh(map.points, map.triangles), map.sizes);
    const ScalarField field{.values = quantity == Quantity::Size ? map.sizes : shocks,
                            .scale = Scale::Logarithmic,
                            .range = range,
                            .title = quantity == Quantity::Size ? "size" : "H-shock"};
    return render({.points = map.points, .triangles = map.triangles, .field = field}, usual_view(map.points),
                  {.edge_width = 0});
}

std::vector<Picture> pictures_of(const SurfaceMesh& mesh, const std::optional<DrawnMesh>& input) {
    std::vector<Picture> pictures;
    if (input)
        pictures.push_back({"input", fmt::format("the input, {} triangles", input->triangles.size()),
                            render(*input, usual_view(mesh.points))});
    pictures.push_back(
        {"mesh", fmt::format("{} triangles", mesh.triangles.size()), draw(mesh, usual_view(mesh.points))});
    pictures.push_back(
        {"size", "sizes asked for", draw(SizedTriangles{mesh.points, mesh.triangles, mesh.sizes}, Quantity::Size)});
    int number = 0;
    for (const Camera& camera : enlargements(mesh, 2)) {
        const std::string index = std::to_string(++number);
        if (input) pictures.push_back({"input-" + index, "the input there, " + index, render(*input, camera)});
        pictures.push_back({"enlargement-" + index, "where sizes change most, " + index, draw(mesh, camera)});
    }
    return pictures;
}

}  // namespace gradus::app
