// Features of triangulations whose creases, rims and corners are known.
#include "gradus/mesh/features.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "support/parts.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

struct Found {
    Connectivity mesh;
    Features features;
    int corners() const { return static_cast<int>(std::count(features.corner.begin(), features.corner.end(), 1)); }
    int closed() const {
        return static_cast<int>(std::count_if(features.chains.begin(), features.chains.end(),
                                              [](const FeatureChain& c) { return c.closed; }));
    }
};

// Tags, chains and corners say the same.
void check_consistent(const Found& found) {
    const auto& chains = found.features.chains;
    std::map<std::array<int, 2>, int> edges;
    for (int c = 0; c < static_cast<int>(chains.size()); ++c) {
        const FeatureChain& chain = chains[c];
        REQUIRE(chain.num_edges() >= 1);
        for (int i = 0; i < chain.num_edges(); ++i) {
            const int a = chain.vertex(i), b = chain.vertex(i + 1);
            CHECK(edges.emplace(std::array{std::min(a, b), std::max(a, b)}, c).second);
        }
        for (int i = 0; i < static_cast<int>(chain.vertices.size()); ++i) {
            const bool end = !chain.closed && (i == 0 || i + 1 == static_cast<int>(chain.vertices.size()));
            CHECK(bool(found.features.corner[chain.vertices[i]]) == end);
        }
    }
    std::size_t tagged = 0;
    for (int h = 0; h < 3 * found.mesh.num_triangles(); ++h) {
        const int a = found.mesh.origin(h), b = found.mesh.target(h);
        const auto it = edges.find({std::min(a, b), std::max(a, b)});
        CHECK(found.mesh.tag(h) == (it == edges.end() ? -1 : it->second));
        if (found.mesh.tag(h) >= 0) tagged += found.mesh.twin(h) < h;
        if (found.mesh.twin(h) < 0) CHECK(found.mesh.tag(h) >= 0);
    }
    CHECK(tagged == edges.size());
}

Found found_in(const Mesh& mesh, const FeatureOptions& options = {}, const KnownFeatures& known = {}) {
    Found found{Connectivity(static_cast<int>(mesh.points.size()), mesh.triangles), {}};
    found.features = find_features(mesh.points, found.mesh, options, known);
    check_consistent(found);
    return found;
}

double flat(double, double) { return 0; }

}  // namespace

TEST_CASE("a cube has twelve chains between eight corners, where three wedges meet", "[exact]") {
    const int n = GENERATE(1, 2, 5);
    const Mesh mesh = triangulations::cube(n);
    const Found found = found_in(mesh);
    CHECK(found.features.chains.size() == 12);
    CHECK(found.closed() == 0);
    CHECK(found.corners() == 8);
    for (const FeatureChain& chain : found.features.chains) {
        CHECK(chain.num_edges() == n);
        CHECK((mesh.points[chain.vertices.front()] - mesh.points[chain.vertices.back()]).norm() == Approx(1));
    }
    const Wedges wedges = wedges_of(found.mesh);
    std::vector<int> count(mesh.points.size(), 0), corners(wedges.size(), 0);
    for (int w = 0; w < wedges.size(); ++w) ++count[wedges.vertex[w]];
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        int faces = 0;
        for (int k = 0; k < 3; ++k) faces += mesh.points[v][k] == 0 || mesh.points[v][k] == 1;
        CHECK(count[v] == faces);
        CHECK(wedges.vertex[v] == static_cast<int>(v));
    }
    // Each corner of a triangle is in one wedge, and for_each passes all of them.
    for (int w = 0; w < wedges.size(); ++w)
        wedges.for_each(found.mesh, w, [&](int h) {
            CHECK(wedges.of_corner[h] == w);
            CHECK(found.mesh.origin(h) == wedges.vertex[w]);
            ++corners[w];
        });
    CHECK(std::accumulate(corners.begin(), corners.end(), 0) == 3 * static_cast<int>(mesh.triangles.size()));
}

TEST_CASE("a smooth closed surface has no features, and one wedge per vertex", "[exact]") {
    const Mesh mesh = GENERATE(triangulations::sphere(3), triangulations::torus(30, 14));
    const Found found = found_in(mesh);
    CHECK(found.features.chains.empty());
    CHECK(found.corners() == 0);
    CHECK(wedges_of(found.mesh).size() == static_cast<int>(mesh.points.size()));
}

TEST_CASE("a capped cylinder has its two rims, also where its sides are few", "[exact]") {
    // Eight sides turn by 45 degrees, more than the angle of a crease: but the surface turns on as fast.
    const int sides = GENERATE(8, 12, 24, 60), rows = GENERATE(1, 4);
    CAPTURE(sides, rows);
    const Mesh mesh = triangulations::capped_cylinder(sides, rows);
    const Found found = found_in(mesh);
    std::array<int, 2> rims{0, 0};
    for (const FeatureChain& chain : found.features.chains) {
        const double z = mesh.points[chain.vertices[0]].z();
        CHECK((z == 0 || z == 2));
        for (const int v : chain.vertices) CHECK(mesh.points[v].z() == z);
        rims[z > 1] += chain.num_edges();
    }
    CHECK(rims == std::array{sides, sides});
    // A rim of eight sides turns by the angle of a corner.
    if (sides == 8) return;
    CHECK(found.features.chains.size() == 2);
    CHECK(found.closed() == 2);
    CHECK(found.corners() == 0);
}

TEST_CASE("an open grid has four boundary chains between its corners", "[exact]") {
    const Mesh mesh = triangulations::graph(9, flat);
    const Found found = found_in(mesh);
    CHECK(found.features.chains.size() == 4);
    CHECK(found.corners() == 4);
    for (const FeatureChain& chain : found.features.chains) CHECK(chain.num_edges() == 9);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const Vector3d& p = mesh.points[v];
        CHECK(bool(found.features.corner[v]) == ((p.x() == 0 || p.x() == 1) && (p.y() == 0 || p.y() == 1)));
    }
    CHECK(found_in(testing::annulus(24, 3)).closed() == 2);
}

TEST_CASE("jags of a boundary are corners where they are higher than the scale", "[exact]") {
    constexpr int n = 12, all = (n - 5) + (n - 4);
    constexpr double height = 0.6;
    Mesh mesh;
    for (const double y : {0.0, 1.0})
        for (int i = 0; i <= n; ++i) mesh.points.emplace_back(i, y, 0);
    for (int i = 0; i < n; ++i) {
        mesh.points.emplace_back(i + 0.5, 1 + height, 0);
        const int a = i, b = a + 1, c = a + n + 1, d = c + 1, tip = 2 * (n + 1) + i;
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}, {c, d, tip}});
    }
    // On what is no plane jags may be noise; outlines of planes are what they are.
    const bool is_plane = GENERATE(false, true);
    if (!is_plane)
        for (std::size_t v = 0; v < mesh.points.size(); ++v)
            mesh.points[v].z() = 0.01 * std::sin(37.0 * static_cast<double>(v * v));
    const auto inner_corners = [&](double scale) {
        const Found found = found_in(mesh, {.scale = scale});
        int count = 0;
        // Near the ends the boundary turns all in all.
        for (std::size_t v = 0; v < mesh.points.size(); ++v)
            count += found.features.corner[v] && mesh.points[v].x() > 2 && mesh.points[v].x() < n - 2;
        return count;
    };
    CHECK(inner_corners(0) == (is_plane ? all : 0));
    CHECK(inner_corners(1.01 * height) == (is_plane ? all : 0));
    CHECK(inner_corners(0.99 * height) == all);
    CHECK(inner_corners(10 * height) == 0);
}

TEST_CASE("borders between labels are features, and what is given", "[exact]") {
    const Mesh mesh = triangulations::graph(8, flat, 0);
    const auto middle = [&](const Triangle& t) {
        return Vector3d((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3);
    };
    const auto inner = [&](const Found& found) {
        int edges = 0;
        for (int h = 0; h < 3 * found.mesh.num_triangles(); ++h)
            edges += found.mesh.tag(h) >= 0 && found.mesh.twin(h) > h;
        return edges;
    };
    SECTION("a border across") {
        std::vector<int> labels;
        for (const Triangle& t : mesh.triangles) labels.push_back(middle(t).x() < 0.5 ? 2 : -7);
        const Found found = found_in(mesh, {}, {.labels = labels});
        CHECK(found.features.chains.size() == 7);
        CHECK(found.corners() == 6);
        CHECK(inner(found) == 8);
    }
    SECTION("a patch inside") {
        std::vector<int> labels;
        for (const Triangle& t : mesh.triangles)
            labels.push_back((middle(t) - Vector3d(.5, .5, 0)).cwiseAbs().maxCoeff() < 0.25);
        const Found found = found_in(mesh, {}, {.labels = labels});
        CHECK(inner(found) == 16);
        CHECK(found.corners() == 8);
        CHECK(found.features.chains.size() == 8);
    }
    SECTION("edges and corners") {
        const int n = 9, row = 4;
        std::vector<std::array<int, 2>> edges;
        for (int i = 2; i < 5; ++i) edges.push_back({row * n + i + 1, row * n + i});
        const std::vector<int> corners{row * n + 3, 2 * n + 2};
        const Found found = found_in(mesh, {}, {.edges = edges, .corners = corners});
        CHECK(inner(found) == 3);
        for (const int v : corners) CHECK(found.features.corner[v] == 1);
        CHECK(found.corners() == 4 + 2 + 2);
        CHECK(found.features.chains.size() == 4 + 2);
    }
}

TEST_CASE("a fold is a crease from its angle on", "[exact]") {
    const double degrees = GENERATE(1., 10., 20., 35., 45., 90., 150.);
    const double half = degrees * std::numbers::pi / 360;
    Mesh mesh = triangulations::graph(8, flat, 0);
    for (Vector3d& p : mesh.points)
        p = {(p.x() - 0.5) * std::cos(half), p.y(), -std::abs(p.x() - 0.5) * std::sin(half)};
    CAPTURE(degrees);
    // Where no planes meet it takes more to be a crease.
    Mesh bumpy = mesh;
    for (std::size_t v = 0; v < bumpy.points.size(); ++v)
        if (bumpy.points[v].x() != 0) bumpy.points[v].z() += 1e-4 * static_cast<double>(v * v % 7);
    const Found found = found_in(mesh);
    CHECK(found.features.chains.size() == (degrees > 2 ? 7 : 4));
    CHECK(found_in(bumpy, {.scale = 0.001}).features.chains.size() == (degrees > 40 ? 7 : 4));
    if (degrees > 6) CHECK(found_in(bumpy, {.angle = 0.1, .weak_angle = 0.1}).features.chains.size() == 7);
    // Without the crease, the boundary still turns at its ends.
    const Found boundary = found_in(bumpy, {.angle = 3, .sharp_angle = 3});
    for (const FeatureChain& chain : boundary.features.chains)
        for (int i = 0; i < chain.num_edges(); ++i) CHECK(boundary.mesh.is_boundary_vertex(chain.vertex(i)));
    CHECK(boundary.features.chains.size() == (degrees > 45 ? 6 : 4));
}

TEST_CASE("noise below the angle gives no feature", "[property]") {
    const unsigned seed = GENERATE(range(1u, 5u));
    const Mesh sphere = triangulations::sphere(4);
    CHECK(found_in(triangulations::noisy(sphere, 0.04 * triangulations::mean_edge(sphere), seed))
              .features.chains.empty());
    const Mesh cube = triangulations::cube(8);
    const Found found = found_in(triangulations::noisy(cube, 0.03 * triangulations::mean_edge(cube), seed));
    CHECK(found.features.chains.size() == 12);
    CHECK(found.corners() == 8);
}

TEST_CASE("spikes and folds of a rough surface are no features, coarse parts keep theirs", "[property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    const Mesh sphere = triangulations::sphere(3);
    const Found rough = found_in(triangulations::noisy(sphere, 0.35 * triangulations::mean_edge(sphere), seed));
    int edges = 0;
    for (const FeatureChain& chain : rough.features.chains) edges += chain.num_edges();
    CHECK(edges <= 0.01 * 1.5 * double(sphere.triangles.size()));
    // Rings of four edges, and corners all along: but flat beside.
    const Found box = found_in(triangulations::cube(1));
    CHECK(box.features.chains.size() == 12);
    CHECK(found_in(triangulations::capped_cylinder(4, 1)).features.chains.size() >= 8);
}

TEST_CASE("at places that need features folds of a rough surface are some", "[property]") {
    const Mesh rough = triangulations::noisy(triangulations::sphere(3),
                                             0.35 * triangulations::mean_edge(triangulations::sphere(3)), 2);
    const Found before = found_in(rough);
    const auto turn = [&](int h) {
        const auto normal = [&](int t) {
            const Triangle v = before.mesh.triangle(t);
            return (rough.points[v[1]] - rough.points[v[0]])
                .cross(rough.points[v[2]] - rough.points[v[0]])
                .normalized();
        };
        return std::acos(std::clamp(normal(h / 3).dot(normal(before.mesh.twin(h) / 3)), -1.0, 1.0));
    };
    const auto middle = [&](int h) {
        return Vector3d((rough.points[before.mesh.origin(h)] + rough.points[before.mesh.target(h)]) / 2);
    };
    FeatureOptions options{.reach = 1e-6};
    std::vector<int> folds;
    for (int h = 0; h < 3 * before.mesh.num_triangles() && folds.size() < 10; ++h)
        if (before.mesh.twin(h) > h && before.mesh.tag(h) < 0 && turn(h) > 1.1) folds.push_back(h);
    REQUIRE(folds.size() == 10);
    for (const int h : folds) options.places.push_back(middle(h));
    const int flat = [&] {
        for (int h = 0;; ++h)
            if (before.mesh.twin(h) > h && turn(h) < 0.9 && before.mesh.tag(h) < 0) return h;
    }();
    options.places.push_back(middle(flat));
    const Found after = found_in(rough, options);
    for (const int h : folds) CHECK(after.mesh.tag(h) >= 0);
    CHECK(after.mesh.tag(flat) < 0);
}

TEST_CASE("a ridge below the scale is no feature", "[exact]") {
    // A roof of slope 1 and height 0.01 along the middle of the sheet.
    const double height = 0.01;
    Mesh mesh = testing::square(20);
    for (Vector3d& p : mesh.points) {
        const double x = p.x() - 0.5;
        p.x() = 0.5 + (std::abs(x) < 0.051 ? 0.2 * x : x);
        p.z() = std::max(0.0, height - std::abs(p.x() - 0.5));
    }
    const Found all = found_in(mesh);
    CHECK(all.features.chains.size() > 4);
    CHECK(found_in(mesh, {.scale = 0.001}).features.chains.size() == all.features.chains.size());
    CHECK(found_in(mesh, {.scale = 0.2}).features.chains.size() == 4);
}

namespace {

// A sheet that is folded twice by 44 degrees, along lines some width apart, so 88 in all.
Mesh bevel(int n, double width) {
    Mesh mesh = testing::square(n);
    const double turn = 44 * std::numbers::pi / 180;
    for (Vector3d& p : mesh.points) {
        const int column = static_cast<int>(std::lround(p.x() * n));
        // From the left line to the right along the arc.
        const double left = std::min(column - n / 2, 0) / double(n),
                     right = std::max(column - n / 2 - 1, 0) / double(n);
        const Vector3d beyond(std::cos(turn), 0, -std::sin(turn)), last(std::cos(2 * turn), 0, -std::sin(2 * turn));
        p = Vector3d(left, p.y(), 0) + (column > n / 2 ? width * beyond : Vector3d(0, 0, 0)) + right * last;
    }
    return mesh;
}

}  // namespace

TEST_CASE("of two creases that are closer than what creases rise one counts", "[exact]") {
    const double scale = 0.1, width = GENERATE(1e-6, 0.005, 0.012);
    CAPTURE(width);
    const Mesh mesh = bevel(20, width);
    CHECK(found_in(mesh).features.chains.size() == 10);
    const Found found = found_in(mesh, {.scale = scale});
    CHECK(found.features.chains.size() == 7);
    CHECK(found.corners() == 6);
    CHECK(found_in(testing::relabelled(mesh, 9), {.scale = scale}).features.chains.size() == 7);
    CHECK(found_in(bevel(20, 0.02), {.scale = scale}).features.chains.size() == 10);
    // Where the facets are not much longer than the strip is wide they are what they are.
    CHECK(found_in(bevel(20, 0.02), {.scale = 0.2}).features.chains.size() == 10);
}

namespace {

// A prism over a polygon of many sides, whose caps have an ear at every other vertex and a fan inside these.
Mesh eared_prism(int sides) {
    Mesh mesh;
    for (const double z : {0.0, 1.0})
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * std::numbers::pi * i / sides;
            mesh.points.emplace_back(std::cos(angle), std::sin(angle), z);
        }
    mesh.points.emplace_back(0, 0, 0);
    mesh.points.emplace_back(0, 0, 1);
    const auto add = [&](bool turned, int a, int b, int c) {
        mesh.triangles.push_back(turned ? Triangle{a, c, b} : Triangle{a, b, c});
    };
    for (const int cap : {0, 1})
        for (int i = 0; i < sides; i += 2) {
            const auto rim = [&](int k) { return cap * sides + k % sides; };
            add(cap == 0, rim(i), rim(i + 1), rim(i + 2));
            add(cap == 0, 2 * sides + cap, rim(i), rim(i + 2));
        }
    for (int i = 0; i < sides; ++i) {
        const int j = (i + 1) % sides;
        add(false, i, j, sides + j);
        add(false, i, sides + j, sides + i);
    }
    return mesh;
}

}  // namespace

TEST_CASE("a rim is no double of itself beside narrow ears", "[exact]") {
    const Mesh prism = eared_prism(64);
    for (const unsigned seed : {0u, 1u, 2u}) {
        const Found found = found_in(seed == 0 ? prism : testing::relabelled(prism, seed), {.scale = 0.1});
        CHECK(found.features.chains.size() == 2);
        CHECK(found.corners() == 0);
        for (const FeatureChain& chain : found.features.chains) CHECK(chain.num_edges() == 64);
    }
}

TEST_CASE("where a strip becomes wide enough its second crease begins at the first", "[exact]") {
    const int n = 20;
    const double scale = 0.1;
    Mesh mesh = bevel(n, 0);
    // The strip is a wedge: .04 wide at one end.
    const double turn = 44 * std::numbers::pi / 180;
    for (int v = 0; v < std::ssize(mesh.points); ++v) {
        const int column = static_cast<int>(std::lround(testing::square(n).points[v].x() * n));
        if (column > n / 2)
            mesh.points[v] += (1e-6 + 0.04 * mesh.points[v].y()) * Vector3d(std::cos(turn), 0, -std::sin(turn));
    }
    const Found found = found_in(mesh, {.scale = scale});
    // One crease along the whole sheet, and another from it to the wide end: they meet at a corner within.
    int inner = 0;
    for (int v = 0; v < std::ssize(mesh.points); ++v) {
        if (!found.features.corner[v] || found.mesh.is_boundary_vertex(v)) continue;
        ++inner;
        CAPTURE(mesh.points[v].transpose());
        CHECK(mesh.points[v].y() > 0.2);
        CHECK(mesh.points[v].y() < 0.6);
    }
    CHECK(inner == 1);
    CHECK(found.features.chains.size() == 4 + 3 + 3);
}

TEST_CASE("features do not depend on numbers, place or size", "[property]") {
    const Mesh mesh = triangulations::capped_cylinder(20, 5, 1, 2, 3);
    const Found a = found_in(mesh), b = found_in(testing::relabelled(mesh, 4)),
                c = found_in(testing::moved(mesh, 1e-5));
    const auto edges = [](const Found& found) {
        int sum = 0;
        for (const FeatureChain& chain : found.features.chains) sum += chain.num_edges();
        return sum;
    };
    for (const Found* other : {&b, &c}) {
        CHECK(other->features.chains.size() == a.features.chains.size());
        CHECK(edges(*other) == edges(a));
        CHECK(other->corners() == a.corners());
    }
}

TEST_CASE("the rim of a coarse cylinder has no corners, that of a square prism has four", "[exact]") {
    const int sides = GENERATE(4, 8, 12);
    CAPTURE(sides);
    const TriangleSoup soup = parts::prism(parts::polygon(sides), 2);
    const Found prism = found_in(Mesh{soup.points, soup.triangles}, {.scale = 0.001});
    const auto corners = std::count(prism.features.corner.begin(), prism.features.corner.end(), 1);
    CHECK(corners == (sides == 4 ? 8 : 0));
    CHECK(prism.features.chains.size() == (sides == 4 ? 12U : 2U));
}

TEST_CASE("a row of facets around a vertex that ends all around is a cone, further rows that turn on are round",
          "[exact]") {
    const double height = GENERATE(0., 0.1, 0.4);
    TriangleSoup cone = parts::twisted(parts::polygon(24), 2, 0, 1);
    const int top = static_cast<int>(cone.points.size()) - 1;
    cone.points[top].z() += height;
    const Found found = found_in(Mesh{cone.points, cone.triangles}, {.scale = 0.001});
    CHECK(found.features.chains.size() == 2);
    CHECK((found.features.corner[top] != 0) == (height > 0));
    CHECK(std::count(found.features.corner.begin(), found.features.corner.end(), 1) == (height > 0));
    const Mesh dome = triangulations::sphere(2);
    const Found round = found_in(dome);
    CHECK(std::count(round.features.corner.begin(), round.features.corner.end(), 1) == 0);
}
