// Remeshing a triangulation: topology, features and corners are kept, triangles are good, and runs repeat.
#include "gradus/remesh/triangulated.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <numeric>
#include <optional>
#include <set>

#include "gradus/control/control_space.hpp"
#include "gradus/control/triangulation.hpp"
#include "gradus/quality/report.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

struct Remeshed {
    RemeshResult result;
    MeshReport before, after;
    MeshView view() const { return {result.mesh.points, result.mesh.triangles}; }
};

Remeshed remeshed(const Triangulation& surface, const SizingRule& rule, const RemeshOptions& options = {},
                  MeshChecks* checks = nullptr, const SmoothSupport::Options& smooth = {}) {
    const TriangulationBackground map = make_background(surface, rule);
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support(smooth);
    Remeshed made{
        remesh({support, surface.features(), surface.soup().labels}, control, map.cells, options, checks), {}, {}};
    made.before = measure({surface.soup().points, surface.soup().triangles});
    made.after = measure(made.view(), {.sizes = made.result.mesh.sizes});
    return made;
}

SizingRule uniform(double h) {
    return {.kind = SizingRule::Kind::Proportional, .value = 1e6, .hmin = 0.999999 * h, .hmax = h};
}

void check_topology_kept(const Remeshed& made) {
    const TopologyReport &a = made.before.topology, &b = made.after.topology;
    CHECK(b.oriented_manifold());
    CHECK(b.euler == a.euler);
    CHECK(b.boundary_loops == a.boundary_loops);
    CHECK(b.components == a.components);
    CHECK(b.unused_vertices == 0);
    CHECK(b.bad_points == 0);
    CHECK(b.duplicate_positions == 0);
    CHECK(made.result.mesh.sizes.size() == made.result.mesh.points.size());
    CHECK(made.result.mesh.places.size() == made.result.mesh.points.size());
}

void check_good(const Remeshed& made, double mean = 0.95) {
    CHECK(made.after.shape.area_length.min >= 0.6);
    CHECK(made.after.shape.area_length.mean >= mean);
    CHECK(made.after.edges->unit_share >= 0.95);
}

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (p - a - t * (b - a)).norm();
}

double signed_volume(const MeshView& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles)
        sum += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]])) / 6;
    return sum;
}

}  // namespace

TEST_CASE("a sphere is remeshed with good triangles of the size asked for, near the sphere and not inside it",
          "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(4)));
    const bool fast = GENERATE(false, true);
    CAPTURE(fast);
    const Remeshed made = remeshed(surface, uniform(0.18), {.fast = fast});
    check_topology_kept(made);
    // The fast schedule promises less.
    if (!fast) check_good(made);
    CHECK(made.after.shape.area_length.min >= 0.5);
    CHECK(made.after.shape.area_length.mean >= 0.9);
    CHECK(made.after.edges->unit_share >= 0.75);
    CHECK(made.result.mesh.features.empty());
    // Points lie on the smooth surface, much nearer to the sphere than the facets, which are off by 5e-3.
    double farthest = 0;
    for (const Vector3d& p : made.result.mesh.points) farthest = std::max(farthest, std::abs(p.norm() - 1));
    CHECK(farthest < 5e-4);
    CHECK(signed_volume(made.view()) > 0.95 * 4 * std::numbers::pi / 3);
}

TEST_CASE("a torus keeps its handle", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::torus(60, 22)));
    const Remeshed made = remeshed(surface, uniform(0.3));
    check_topology_kept(made);
    check_good(made);
    CHECK(made.after.topology.genus == 1);
    CHECK(made.result.mesh.features.empty());
}

TEST_CASE("a cube keeps its corners, and its edges to the last digits", "[exact]") {
    const Triangulation surface(triangulations::soup(triangulations::cube(GENERATE(1, 3))));
    const double h = GENERATE(0.11, 0.4);
    CAPTURE(h);
    const Remeshed made = remeshed(surface, uniform(h));
    check_topology_kept(made);
    CHECK(made.after.shape.area_length.min >= 0.5);
    CHECK(signed_volume(made.view()) == Approx(1).epsilon(1e-9));
    std::set<std::array<double, 3>> points;
    for (const Vector3d& p : made.result.mesh.points) {
        points.insert({p.x(), p.y(), p.z()});
        // Faces stay flat.
        double off = 1;
        for (int k = 0; k < 3; ++k) off = std::min({off, std::abs(p[k]), std::abs(p[k] - 1)});
        CHECK(off < 1e-12);
    }
    for (const double x : {0.0, 1.0})
        for (const double y : {0.0, 1.0})
            for (const double z : {0.0, 1.0}) CHECK(points.count({x, y, z}) == 1);
    std::array<double, 12> lengths{};
    for (const auto& [a, b] : made.result.mesh.features) {
        const Vector3d &p = made.result.mesh.points[a], &q = made.result.mesh.points[b];
        int edge = 0, found = 0;
        for (int axis = 0; axis < 3; ++axis)
            for (const double s : {0.0, 1.0})
                for (const double t : {0.0, 1.0}) {
                    Vector3d from, to;
                    from[axis] = 0, to[axis] = 1;
                    from[(axis + 1) % 3] = to[(axis + 1) % 3] = s;
                    from[(axis + 2) % 3] = to[(axis + 2) % 3] = t;
                    if (distance_to_segment(p, from, to) < 1e-12 && distance_to_segment(q, from, to) < 1e-12)
                        lengths[edge] += (p - q).norm(), ++found;
                    ++edge;
                }
        CHECK(found == 1);
    }
    for (const double length : lengths) CHECK(length == Approx(1).epsilon(1e-12));
}

TEST_CASE("a capped cylinder keeps its two rims, round and in their planes", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::capped_cylinder(48, 14, 1, 2, 6)));
    const Remeshed made = remeshed(surface, uniform(0.15));
    check_topology_kept(made);
    check_good(made, 0.975);
    double length = 0;
    for (const auto& [a, b] : made.result.mesh.features) {
        length += (made.result.mesh.points[a] - made.result.mesh.points[b]).norm();
        for (const int v : {a, b}) {
            const Vector3d& p = made.result.mesh.points[v];
            CHECK(std::min(std::abs(p.z()), std::abs(p.z() - 2)) < 1e-12);
            CHECK(std::hypot(p.x(), p.y()) == Approx(1).margin(1e-3));
        }
    }
    CHECK(length == Approx(4 * std::numbers::pi).epsilon(0.01));
    for (const Vector3d& p : made.result.mesh.points) {
        const double off_cap = std::min(std::abs(p.z()), std::abs(p.z() - 2)),
                     off_side = std::abs(std::hypot(p.x(), p.y()) - 1);
        CHECK(std::min(off_cap, off_side) < 1e-3);
    }
}

TEST_CASE("rims are divided into edges of the size asked for, whatever pieces they came in", "[property]") {
    // Pieces of .77, 1.1 and 1.31: neither they nor their halves are near.
    const double h = GENERATE(0.17, 0.119, 0.1);
    CAPTURE(h);
    const Triangulation surface(triangulations::soup(triangulations::capped_cylinder(48, 14, 1, 2, 6)));
    const Remeshed made = remeshed(surface, uniform(h));
    check_topology_kept(made);
    check_good(made, 0.97);
    std::vector<double> lengths;
    for (const auto& [a, b] : made.result.mesh.features)
        lengths.push_back((made.result.mesh.points[a] - made.result.mesh.points[b]).norm() / h);
    const double mean = std::accumulate(lengths.begin(), lengths.end(), 0.0) / static_cast<double>(lengths.size());
    CHECK(mean == Approx(1.04).margin(0.05));
    CHECK(*std::max_element(lengths.begin(), lengths.end()) < 1.4);
    CHECK(*std::min_element(lengths.begin(), lengths.end()) > 0.75);
}

TEST_CASE("an open sheet keeps its boundary and the corners of it", "[property]") {
    const auto wave = [](double x, double y) { return 0.1 * std::sin(6 * x) * std::cos(5 * y); };
    const Triangulation surface(triangulations::soup(triangulations::graph(24, wave)));
    const Remeshed made = remeshed(surface, uniform(0.06));
    check_topology_kept(made);
    check_good(made);
    std::set<std::array<int, 2>> features;
    for (const auto& [a, b] : made.result.mesh.features) features.insert({std::min(a, b), std::max(a, b)});
    const MeshEdges edges = edges_of(made.view());
    for (int e = 0; e < edges.size(); ++e) CHECK((edges.num_uses(e) == 1) == (features.count(edges.ends[e]) == 1));
    for (const auto& [a, b] : features)
        for (const int v : {a, b}) {
            const Vector3d& p = made.result.mesh.points[v];
            CHECK(std::min({std::abs(p.x()), std::abs(p.y()), std::abs(p.x() - 1), std::abs(p.y() - 1)}) < 1e-3);
        }
    for (const double x : {0.0, 1.0})
        for (const double y : {0.0, 1.0}) {
            const Vector3d corner(x, y, wave(x, y));
            CHECK(std::count(made.result.mesh.points.begin(), made.result.mesh.points.end(), corner) == 1);
        }
}

TEST_CASE("labels are kept, and their border is no edge that is crossed", "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::graph(
        12, [](double, double) { return 0; }, 0));
    for (const Triangle& t : soup.triangles)
        soup.labels.push_back((soup.points[t[0]] + soup.points[t[1]] + soup.points[t[2]]).x() / 3 < 0.5 ? 4 : 9);
    const Triangulation surface(std::move(soup));
    const SurfaceMesh mesh = remeshed(surface, uniform(0.07)).result.mesh;
    double area[2] = {0, 0};
    REQUIRE(mesh.patches.size() == mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& v = mesh.triangles[t];
        const bool right = (mesh.points[v[0]] + mesh.points[v[1]] + mesh.points[v[2]]).x() / 3 > 0.5;
        CHECK(mesh.patches[t] == (right ? 9 : 4));
        area[right] += (mesh.points[v[1]] - mesh.points[v[0]]).cross(mesh.points[v[2]] - mesh.points[v[0]]).norm() / 2;
    }
    CHECK(area[0] == Approx(0.5).epsilon(1e-9));
    CHECK(area[1] == Approx(0.5).epsilon(1e-9));
}

TEST_CASE("the same surface and sizes give the same mesh of a triangulation to the last bit", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::capped_cylinder(24, 6, 1, 2, 3)));
    const SurfaceMesh a = remeshed(surface, uniform(0.25), {.threads = 1}).result.mesh,
                      b = remeshed(surface, uniform(0.25), {.threads = 2}).result.mesh;
    CHECK(a.points == b.points);
    CHECK(a.triangles == b.triangles);
    CHECK(a.sizes == b.sizes);
    CHECK(a.features == b.features);
}

TEST_CASE("a map that asks for more triangles than allowed of a triangulation is refused", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::cube(1)));
    CHECK_THROWS_AS(remeshed(surface, uniform(0.02), {.max_triangles = 1000}), std::length_error);
    CHECK_NOTHROW(remeshed(surface, uniform(0.3), {.max_triangles = 1000}));
}

namespace {

// Checks that only have sizes to give.
class Sizes : public MeshChecks {
  public:
    using Rule = std::function<std::optional<std::vector<double>>(const SurfaceMesh& mesh, MeshStage stage)>;
    explicit Sizes(Rule rule) : rule_(std::move(rule)) {}
    std::optional<std::vector<double>> sizes_after(const SurfaceMesh& mesh, MeshStage stage,
                                                   std::span<const Vector3d>) override {
        return rule_(mesh, stage);
    }

  private:
    Rule rule_;
};

}  // namespace

TEST_CASE("checks are asked until they have nothing to say, and their sizes are taken", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(3)));
    bool last_had_nothing = false;
    int halved = 0;
    Sizes checks([&](const SurfaceMesh& mesh, MeshStage) -> std::optional<std::vector<double>> {
        last_had_nothing = halved == 1;
        if (last_had_nothing) return std::nullopt;
        ++halved;
        std::vector<double> sizes = mesh.sizes;
        for (double& h : sizes) h /= 2;
        return sizes;
    });
    const std::size_t coarse = remeshed(surface, uniform(0.4)).result.mesh.triangles.size();
    const std::size_t fine = remeshed(surface, uniform(0.4), {}, &checks).result.mesh.triangles.size();
    CHECK(last_had_nothing);
    CHECK(double(fine) / double(coarse) == Approx(4).epsilon(0.15));
}

namespace {

// Two slopes that meet in a line over or under x = 0, from y = 0 to 4, where vertices are at x = -w, 0 and w; no
// features but the boundary.
TriangleSoup slopes(double w, double height) {
    TriangleSoup soup;
    for (int j = 0; j <= 4; ++j)
        for (const double x : {-w, 0.0, w}) soup.points.emplace_back(x, j, x == 0 ? height : 0);
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 2; ++i) {
            const int a = 3 * j + i, b = a + 1, c = a + 3, d = a + 4;
            soup.triangles.push_back({a, b, d});
            soup.triangles.push_back({a, d, c});
        }
    return soup;
}

// The point half way between the vertices (-w, 1) and (w, 2).
std::optional<Vector3d> half_way(const TriangleSoup& soup, const TriangulationOptions& options) {
    const Triangulation surface(soup, options);
    const TriangulationBackground map = make_background(surface, uniform(1));
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support({.largest_bulge = 1e-9});
    const TriangleSupport places(support, surface.features());
    // By the middle edge's other end on either slope, as vertices on the boundary are on several sides of it.
    const auto foot = places.between(places.at_vertex(3, map.cells[3]).place, places.at_vertex(8, map.cells[8]).place,
                                     Vector3d::UnitZ());
    if (!foot) return std::nullopt;
    return foot->point;
}

constexpr double kNever = 3.1;
const TriangulationOptions kUnfeatured{
    .features = {.angle = kNever, .ridge_angle = kNever, .sharp_angle = kNever, .weak_angle = kNever}};

}  // namespace

TEST_CASE("half way between two vertices along a section is on the ridge or at the bottom between them", "[exact]") {
    for (const double height : {1.0, -1.0, -1.5}) {
        const auto middle = half_way(slopes(0.5, height), kUnfeatured);
        REQUIRE(middle);
        CHECK((*middle - Vector3d(0, 1.5, height)).norm() < 1e-8);
    }
    // Farther than four times their distance is no way from one to the other; nor is one across a crease.
    CHECK_FALSE(half_way(slopes(0.1, -3), kUnfeatured));
    CHECK_FALSE(half_way(slopes(0.5, 1), {}));
}

TEST_CASE("a sharp fold that is no feature is meshed with good triangles", "[property]") {
    TriangulationOptions options = kUnfeatured;
    const Triangulation surface(triangulations::soup(triangulations::cube(6)), options);
    REQUIRE(surface.features().chains.empty());
    const Remeshed made = remeshed(surface, uniform(0.11));
    check_topology_kept(made);
    CHECK(made.after.shape.area_length.min >= 0.6);
    CHECK(made.after.shape.area_length.mean >= 0.95);
}

TEST_CASE("sizes that jump from vertex to vertex leave a sound mesh", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(3)));
    int rounds = 0;
    Sizes checks([&](const SurfaceMesh& mesh, MeshStage stage) -> std::optional<std::vector<double>> {
        if (stage == MeshStage::Draft || ++rounds > 2) return std::nullopt;
        std::vector<double> sizes = mesh.sizes;
        for (std::size_t v = 0; v < sizes.size(); v += 2)
            if ((mesh.points[v] - Vector3d(1, 0, 0)).norm() < 0.5) sizes[v] /= 20;
        return sizes;
    });
    const MeshReport report = remeshed(surface, uniform(0.3), {}, &checks).after;
    CHECK(rounds == 3);
    CHECK(report.shape.area_length.min >= 0.3);
    CHECK(report.topology.euler == 2);
}

namespace {

// Lets nothing change once the meshes are as good as the sizes make them.
class Unyielding : public MeshChecks {
  public:
    std::optional<std::vector<double>> sizes_after(const SurfaceMesh& mesh, MeshStage,
                                                   std::span<const Vector3d>) override {
        last = mesh;
        return std::nullopt;
    }
    bool allows(const MeshPart& part) override {
        ++asked;
        CHECK(part.changed > 0);
        CHECK(part.changed < std::ssize(part.triangles));
        CHECK(part.places.size() == part.points.size());
        return false;
    }

    SurfaceMesh last;
    int asked = 0;
};

std::vector<std::array<double, 3>> sorted_points(const SurfaceMesh& mesh) {
    std::vector<std::array<double, 3>> points;
    for (const Vector3d& p : mesh.points) points.push_back({p.x(), p.y(), p.z()});
    std::sort(points.begin(), points.end());
    return points;
}

}  // namespace

TEST_CASE("what checks do not allow is not done", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::cube(3)));
    Unyielding checks;
    const SurfaceMesh mesh = remeshed(surface, uniform(0.17), {}, &checks).result.mesh;
    CHECK(checks.asked > 0);
    CHECK(sorted_points(mesh) == sorted_points(checks.last));
    CHECK(mesh.triangles.size() == checks.last.triangles.size());
}

namespace {

// At fault wherever a point of the surface has no vertex of the mesh near it; allows what brings one there.
class Wanting : public MeshChecks {
  public:
    Wanting(const Vector3d& point, double reach) : point_(point), reach_(reach) {}
    std::vector<MeshFault> faults_of(const SurfaceMesh& mesh) override {
        const double nearest = nearest_in(mesh.points);
        if (meshes++ == 0) first_nearest = nearest;
        last_nearest = nearest;
        if (nearest <= reach_) return {};
        MeshFault fault{point_, nearest, {}};
        for (int t = 0; t < std::ssize(mesh.triangles); ++t)
            for (const int v : mesh.triangles[t])
                if ((mesh.points[v] - point_).norm() == nearest) fault.triangles.push_back(t);
        return {fault};
    }
    std::optional<std::vector<double>> sizes_after(const SurfaceMesh&, MeshStage, std::span<const Vector3d>) override {
        return std::nullopt;
    }
    bool allows(const MeshPart& part) override {
        if (!part.fault) return false;  // not when polishing
        CHECK(*part.fault == point_);
        return nearest_in(part.points) <= reach_;
    }

    int meshes = 0;
    double first_nearest = 0, last_nearest = 0;

  private:
    double nearest_in(std::span<const Vector3d> points) const {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vector3d& p : points) nearest = std::min(nearest, (p - point_).norm());
        return nearest;
    }
    Vector3d point_;
    double reach_;
};

}  // namespace

TEST_CASE("a fault of a mesh is mended at its place alone", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(4)));
    const SurfaceMesh before = remeshed(surface, uniform(0.3)).result.mesh;
    const Vector3d wanted = Vector3d(0.3, -0.5, 0.7).normalized();
    Wanting checks(wanted, 0.03);
    const Remeshed made = remeshed(surface, uniform(0.3), {}, &checks);
    CHECK(checks.first_nearest > 0.03);
    CHECK(checks.last_nearest <= 0.03);
    check_topology_kept(made);
    CHECK(made.after.shape.area_length.min >= 0.5);
    CHECK(std::abs(std::ssize(made.result.mesh.triangles) - std::ssize(before.triangles)) <
          0.1 * double(before.triangles.size()));
}

namespace {

// Lowers sizes by a factor where that is asked for, if that is below 1, and lets no element be polished.
class Retrying : public Unyielding {
  public:
    explicit Retrying(double factor) : factor_(factor) {}
    std::optional<std::vector<double>> sizes_below(const SurfaceMesh& mesh, std::span<const Vector3d> places,
                                                   double factor) override {
        CHECK_FALSE(places.empty());
        ++asked_below;
        CHECK(factor < 1);
        if (factor_ == 1) return std::nullopt;
        std::vector<double> sizes = mesh.sizes;
        for (std::size_t v = 0; v < sizes.size(); ++v)
            for (const Vector3d& p : places)
                if ((mesh.points[v] - p).norm() < 1.5 * mesh.sizes[v])
                    sizes[v] = std::min(factor, factor_) * mesh.sizes[v];
        return sizes;
    }
    void take_back() override { ++taken_back; }
    std::vector<MeshFault> faults_of(const SurfaceMesh& mesh) override {
        checked_last = mesh;
        return {};
    }

    int asked_below = 0, taken_back = 0;
    SurfaceMesh checked_last;

  private:
    double factor_;
};

std::size_t short_of_limits(const MeshReport& report) {
    std::size_t count = 0;
    for (const OffenderGroup& group : report.offenders.groups)
        if (group.cause.kind == OffenderCause::Kind::None || group.cause.kind == OffenderCause::Kind::SharpTurn)
            count += group.quality.count + group.angle.count + group.edge_ratio.count;
    return count;
}

}  // namespace

TEST_CASE("where elements are bad without a cause another mesh is tried, and taken if it is better", "[property]") {
    const unsigned seed = GENERATE(1u, 2u, 3u, 4u);
    CAPTURE(seed);
    const testing::Mesh sphere = triangulations::sphere(3);
    const Triangulation surface(
        triangulations::soup(triangulations::noisy(sphere, 0.5 * triangulations::mean_edge(sphere), seed)),
        kUnfeatured);
    const RemeshOptions careless{.goal = 0.1};
    Retrying content(1), retrying(0.8);
    const Remeshed first = remeshed(surface, uniform(0.15), careless, &content),
                   second = remeshed(surface, uniform(0.15), careless, &retrying);
    REQUIRE(short_of_limits(first.after) > 0);
    CHECK(content.asked_below == 1);
    CHECK(retrying.asked_below >= 1);
    check_topology_kept(second);
    CHECK(retrying.taken_back <= 4);
    // What is returned is what was checked last.
    CHECK(sorted_points(second.result.mesh) == sorted_points(retrying.checked_last));
    if (retrying.taken_back == retrying.asked_below)
        CHECK(sorted_points(second.result.mesh) == sorted_points(first.result.mesh));
    else
        CHECK(short_of_limits(second.after) < short_of_limits(first.after));
}

namespace {

// At fault where the triangles at a place have an edge above a length, which no single operation may mend.
class WantingShort : public Retrying {
  public:
    WantingShort(const Vector3d& place, double most) : Retrying(0.8), place_(place), most_(most) {}
    std::vector<MeshFault> faults_of(const SurfaceMesh& mesh) override {
        Retrying::faults_of(mesh);
        MeshFault fault{place_, 0, {}};
        const auto distance = [&](int v) { return (mesh.points[v] - place_).norm(); };
        int nearest = 0;
        for (int v = 1; v < std::ssize(mesh.points); ++v)
            if (distance(v) < distance(nearest)) nearest = v;
        for (int t = 0; t < std::ssize(mesh.triangles); ++t) {
            const Triangle& v = mesh.triangles[t];
            if (std::find(v.begin(), v.end(), nearest) == v.end()) continue;
            fault.triangles.push_back(t);
            for (int k = 0; k < 3; ++k)
                fault.distance = std::max(fault.distance, (mesh.points[v[k]] - mesh.points[v[(k + 1) % 3]]).norm());
        }
        lengths.push_back(fault.distance);
        return fault.distance > most_ ? std::vector{fault} : std::vector<MeshFault>{};
    }

    std::vector<double> lengths;

  private:
    Vector3d place_;
    double most_;
};

}  // namespace

TEST_CASE("at faults that are left sizes are lowered again", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(4)));
    const Vector3d place = Vector3d(0.3, -0.5, 0.7).normalized();
    // What lowering twice gives, not once.
    WantingShort checks(place, 0.24);
    const Remeshed made = remeshed(surface, uniform(0.3), {}, &checks);
    CAPTURE(checks.lengths);
    CHECK(checks.lengths.front() > 0.24);
    CHECK(checks.lengths.back() <= 0.24);
    CHECK(checks.asked_below >= 1);
    check_topology_kept(made);
    CHECK(made.after.shape.area_length.min >= 0.6);
    // Elsewhere elements are as large as they were.
    const SurfaceMesh before = remeshed(surface, uniform(0.3)).result.mesh;
    CHECK(std::ssize(made.result.mesh.triangles) < 1.3 * double(before.triangles.size()));
    // What cannot be is given up.
    WantingShort greedy(place, 0.001);
    remeshed(surface, uniform(0.3), {}, &greedy);
    CHECK(greedy.asked_below <= 6);
}

TEST_CASE("a mesh stays what it is where another one would have more triangles than there may be", "[property]") {
    const testing::Mesh sphere = triangulations::sphere(3);
    const Triangulation surface(
        triangulations::soup(triangulations::noisy(sphere, 0.5 * triangulations::mean_edge(sphere), 1)), kUnfeatured);
    RemeshOptions careless{.goal = 0.1};
    Retrying content(1), retrying(0.3);
    const Remeshed first = remeshed(surface, uniform(0.15), careless, &content);
    careless.max_triangles = first.result.statistics.predicted_triangles * 1.0001;
    const Remeshed second = remeshed(surface, uniform(0.15), careless, &retrying);
    CHECK(retrying.asked_below == 4);
    CHECK(retrying.taken_back == 4);
    CHECK(sorted_points(second.result.mesh) == sorted_points(first.result.mesh));
    CHECK(second.result.statistics.predicted_triangles == first.result.statistics.predicted_triangles);
}

TEST_CASE("a narrow corner of a boundary is one triangle", "[property]") {
    const double degrees = GENERATE(30.0, 50.0, 65.0);
    const double turn = degrees * std::numbers::pi / 180;
    const Mesh sector{{{0, 0, 0}, {10, 0, 0}, {10 * std::cos(turn), 10 * std::sin(turn), 0}}, {{0, 1, 2}}};
    const Remeshed made = remeshed(Triangulation(triangulations::soup(sector)), uniform(1));
    check_topology_kept(made);
    check_good(made);
    CAPTURE(degrees, made.after.shape.smallest_angle.min);
    CHECK(made.after.shape.smallest_angle.min > std::min(40.0, 0.98 * degrees));
}

TEST_CASE("a lattice of edges of about the size asked for, though stretched, is not left as it is", "[property]") {
    // Rows of triangles of a quality of .95, all whose edges count as unit.
    const double stretch = GENERATE(1.0, 1.36, 0.72);
    constexpr int n = 40;
    const double base = std::sqrt(stretch), height = std::sqrt(0.75 / stretch);
    Mesh sheet;
    for (int row = 0; row <= n; ++row)
        for (int i = 0; i <= n; ++i) sheet.points.emplace_back(base * (i + 0.5 * (row % 2)), height * row, 0);
    const auto at = [](int row, int i) { return row * (n + 1) + i; };
    for (int row = 0; row < n; ++row)
        for (int i = 0; i < n; ++i) {
            const int a = at(row, i), b = at(row, i + 1), c = at(row + 1, i), d = at(row + 1, i + 1);
            if (row % 2 == 0)
                sheet.triangles.insert(sheet.triangles.end(), {{a, b, c}, {b, d, c}});
            else
                sheet.triangles.insert(sheet.triangles.end(), {{a, b, d}, {a, d, c}});
        }
    const Remeshed made = remeshed(Triangulation(triangulations::soup(sheet)), uniform(1));
    CAPTURE(stretch, made.before.shape.area_length.mean, made.after.shape.area_length.mean);
    check_topology_kept(made);
    check_good(made, 0.968);
}

TEST_CASE("sizes far below coarse, uneven facets that are no features leave no needles", "[property]") {
    const unsigned seed = GENERATE(1u, 2u, 3u, 4u);
    CAPTURE(seed);
    const Triangulation surface(triangulations::soup(triangulations::sphere(1, 1, 0.3, seed)), kUnfeatured);
    const Remeshed made = remeshed(surface, uniform(0.06), {}, nullptr, {.largest_bulge = 0.01});
    const SurfaceMesh& mesh = made.result.mesh;
    const MeshReport& report = made.after;
    CHECK(report.shape.area_length.min >= 0.6);
    CHECK(report.shape.area_length.mean >= 0.96);
    CHECK(report.topology.euler == 2);
    CHECK(report.edges->unit_share >= 0.98);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            CHECK((mesh.points[a] - mesh.points[b]).norm() < 2 * mesh.sizes[a]);
        }
}

TEST_CASE("sizes of a thousandth of the triangles that are given are reached", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(1)));
    const int vertex = 7;
    constexpr double size = 5e-4;
    std::vector<double> sizes(surface.soup().points.size(), 0.5);
    sizes[vertex] = size;
    const TriangulationBackground map = make_background(surface, sizes);
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support();
    const SurfaceMesh mesh =
        remesh({support, surface.features(), surface.soup().labels}, control, map.cells, {.fast = true}).mesh;
    const Vector3d place = surface.soup().points[vertex];
    double shortest = 1;
    for (const Vector3d& p : mesh.points)
        if (const double distance = (p - place).norm(); distance > 0) shortest = std::min(shortest, distance);
    CHECK(shortest < 4 * size);
    CHECK(static_cast<double>(mesh.triangles.size()) > 0.5 * control.predicted_triangles());
}

TEST_CASE("cells and labels of another triangulation are refused", "[mesh]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(2)));
    const TriangulationBackground map = make_background(surface, uniform(0.3));
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support();
    const std::vector<int> short_labels(5, 1);
    CHECK_THROWS_WITH(remesh({support, surface.features()}, control, std::span(map.cells).first(3)),
                      Catch::Contains("3 cells"));
    CHECK_THROWS_WITH(remesh({support, surface.features(), short_labels}, control, map.cells),
                      Catch::Contains("5 labels"));
}
