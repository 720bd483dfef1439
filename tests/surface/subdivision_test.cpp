#include "gradus/surface/subdivision.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "gradus/curvature/principal.hpp"
#include "gradus/surface/glue.hpp"
#include "gradus/surface/surface_model.hpp"

using namespace gradus;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

Cage cube() {
    Cage cage;
    for (const double x : {-1, 1})
        for (const double y : {-1, 1})
            for (const double z : {-1, 1}) cage.points.emplace_back(x, y, z);
    cage.faces = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    return cage;
}

Cage torus(int n, int m) {
    Cage cage;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m, r = 3 + std::cos(v);
            cage.points.emplace_back(r * std::cos(u), r * std::sin(u), std::sin(v));
            const int i1 = (i + 1) % n, j1 = (j + 1) % m;
            cage.faces.push_back({i * m + j, i1 * m + j, i1 * m + j1, i * m + j1});
        }
    return cage;
}

// A prism over a polygon: faces of n and of four corners.
Cage prism(int n) {
    Cage cage;
    std::vector<int> bottom, top;
    for (const double z : {0., 2.})
        for (int i = 0; i < n; ++i)
            cage.points.emplace_back(std::cos(2 * std::numbers::pi * i / n), std::sin(2 * std::numbers::pi * i / n), z);
    for (int i = 0; i < n; ++i) {
        bottom.insert(bottom.begin(), i);
        top.push_back(n + i);
        cage.faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
    }
    cage.faces.push_back(bottom);
    cage.faces.push_back(top);
    return cage;
}

SurfaceModel model_of(const Cage& cage) { return SurfaceModel(limit_surface(cage).topology); }

int count(const SurfaceModel& model, CurveKind kind) {
    return static_cast<int>(std::count_if(model.curves().begin(), model.curves().end(),
                                          [&](const ModelCurve& curve) { return curve.kind == kind; }));
}

}  // namespace

TEST_CASE("limit points of a cube are those of the masks of Catmull and Clark", "[exact]") {
    // A corner of valence 3 goes to (9 p + 4 sum of neighbours + sum of opposite corners) / 24, here (5/9) p of it
    // after symmetry.
    const LimitSurface surface = limit_surface(cube());
    REQUIRE(surface.topology.patches.size() == 6);
    const Vector3d p(-1, -1, -1), neighbours = Vector3d(1, -1, -1) + Vector3d(-1, 1, -1) + Vector3d(-1, -1, 1),
                                  opposite = Vector3d(1, 1, -1) + Vector3d(1, -1, 1) + Vector3d(-1, 1, 1);
    const Vector3d limit = (9 * p + 4 * neighbours + opposite) / 24;
    CHECK((surface.topology.patches[0].surface->position({0, 0}) - limit).norm() < 1e-7);
    CHECK(surface.face == std::vector<int>{0, 1, 2, 3, 4, 5});
}

TEST_CASE("regular patches are bicubic B-splines, their derivatives those of differences", "[exact]") {
    const Cage cage = torus(9, 7);
    const LimitSurface surface = limit_surface(cage);
    const double x = 0.3, y = 0.6;
    const auto basis = [](double t) {
        return std::array{(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                          (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    };
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            sum += basis(x)[i] * basis(y)[j] * cage.points[(i + 9 - 1) % 9 * 7 + (j + 7 - 1) % 7];
    CHECK((surface.topology.patches[0].surface->position({x, y}) - sum).norm() < 1e-14);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0.1, 0.9);
    constexpr double kStep = 1e-4;
    for (const auto& [patch, loops, named] : surface.topology.patches) {
        const Vector2d uv(uniform(random), uniform(random)), du(kStep, 0), dv(0, kStep);
        const Jet2 jet = patch->jet2(uv);
        CHECK((jet.duu - (patch->jet1(uv + du).du - patch->jet1(uv - du).du) / (2 * kStep)).norm() <
              1e-6 * jet.du.norm());
        CHECK((jet.duv - (patch->jet1(uv + dv).du - patch->jet1(uv - dv).du) / (2 * kStep)).norm() <
              1e-6 * jet.du.norm());
        CHECK((jet.dvv - (patch->jet1(uv + dv).dv - patch->jet1(uv - dv).dv) / (2 * kStep)).norm() <
              1e-6 * jet.du.norm());
    }
}

TEST_CASE("limit surfaces are closed and smooth, also where faces are no quadrilaterals", "[exact]") {
    const SurfaceModel prisms = model_of(prism(GENERATE(3, 5, 8)));
    CHECK(prisms.num_components() == 1);
    CHECK(count(prisms, CurveKind::Boundary) == 0);
    CHECK(count(prisms, CurveKind::Crease) == 0);
}

TEST_CASE("sharp edges are creases, boundaries end the surface, holes are left out", "[exact]") {
    Cage cage = cube();
    cage.creases = {{{0, 1}, 10}, {{1, 3}, 10}, {{3, 2}, 10}, {{2, 0}, 10}};
    CHECK(count(model_of(cage), CurveKind::Crease) == 4);
    cage.creases[0].sharpness = 2;
    CHECK(count(model_of(cage), CurveKind::Crease) == 3);
    cage = cube();
    cage.holes = {2};
    CHECK(limit_surface(cage).topology.patches.size() == 5);
    cage = cube();
    cage.faces.pop_back();
    CHECK(count(model_of(cage), CurveKind::Boundary) == 4);
    cage.boundary = Cage::Boundary::None;
    CHECK(limit_surface(cage).topology.patches.size() == 1);
}

TEST_CASE("what keeps a cage from having a limit surface is named", "[exact]") {
    Cage cage = cube();
    CHECK(why_no_limit_surface(cage).empty());
    cage.faces.push_back({0, 1, 7});
    CHECK_THAT(why_no_limit_surface(cage), Catch::Contains("edge 1-2 has 3 faces"));
    cage = cube();
    std::reverse(cage.faces[0].begin(), cage.faces[0].end());
    CHECK_THAT(why_no_limit_surface(cage), Catch::Contains("in the same direction"));
    cage = cube();
    cage.creases = {{{0, 7}, 1}};
    CHECK_THAT(why_no_limit_surface(cage), Catch::Contains("crease 1-8 is no edge"));
    cage = cube();
    cage.faces.push_back({0, 1});
    CHECK_THAT(why_no_limit_surface(cage), Catch::Contains("face 7 has 2 corners"));
    cage = cube();
    cage.points[3].x() = std::numeric_limits<double>::quiet_NaN();
    CHECK_THAT(why_no_limit_surface(cage), Catch::Contains("vertex 4"));
    CHECK_THROWS_AS(limit_surface(cage), std::invalid_argument);
}

namespace {

// An icosahedron, its triangles cut in four so that vertices of valence 5 and regular ones come in.
Cage triangles() {
    Cage cage;
    const double g = std::numbers::phi;
    for (const double a : {-1., 1.})
        for (const double b : {-g, g}) cage.points.insert(cage.points.end(), {{0, a, b}, {a, b, 0}, {b, 0, a}});
    for (int i = 0; i < 12; ++i)
        for (int j = 0; j < 12; ++j)
            for (int k = 0; k < 12; ++k) {
                if (!(i < j && i < k)) continue;
                const Vector3d &p = cage.points[i], &q = cage.points[j], &r = cage.points[k];
                const auto is_side = [](const Vector3d& x, const Vector3d& y) {
                    return std::abs((x - y).norm() - 2) < 1e-9;
                };
                if (is_side(p, q) && is_side(q, r) && is_side(r, p) && (q - p).cross(r - p).dot(p) > 0)
                    cage.faces.push_back({i, j, k});
            }
    cage.points[3] *= 1.4;
    return cage;
}

}  // namespace

TEST_CASE("Loop surfaces are smooth, and their second derivatives are those of the first everywhere", "[exact]") {
    const Cage cage = triangles();
    REQUIRE(cage.faces.size() == 20);
    LimitSurface surface = limit_surface(cage, SubdivisionScheme::Loop);
    REQUIRE(surface.topology.patches.size() == 60);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(0.05, 0.95);
    constexpr double kStep = 1e-5;
    for (int sample = 0; sample < 600; ++sample) {
        const auto& patch = surface.topology.patches[sample % surface.topology.patches.size()].surface;
        const Vector2d uv(uniform(random), uniform(random)), du(kStep, 0), dv(0, kStep);
        const Jet2 jet = patch->jet2(uv);
        const Vector3d duu = (patch->jet1(uv + du).du - patch->jet1(uv - du).du) / (2 * kStep),
                       duv = (patch->jet1(uv + dv).du - patch->jet1(uv - dv).du) / (2 * kStep),
                       dvv = (patch->jet1(uv + dv).dv - patch->jet1(uv - dv).dv) / (2 * kStep);
        CHECK((jet.duu - duu).norm() + (jet.duv - duv).norm() + (jet.dvv - dvv).norm() <
              0.002 * (duu.norm() + duv.norm() + dvv.norm()));
        CHECK((jet.du - (patch->position(uv + du) - patch->position(uv - du)) / (2 * kStep)).norm() <
              1e-6 * jet.du.norm());
    }
    const SurfaceModel model = SurfaceModel(std::move(surface.topology));
    CHECK(model.num_components() == 1);
    CHECK(count(model, CurveKind::Boundary) == 0);
    CHECK(count(model, CurveKind::Crease) == 0);
    CHECK_THAT(why_no_limit_surface(cube(), SubdivisionScheme::Loop), Catch::Contains("face 1 has 4 corners"));
}

namespace {

// The same patches, joined by where their sides lie.
SurfaceModel glued(const Cage& cage, SubdivisionScheme scheme) {
    std::vector<std::unique_ptr<const ParametricSurface>> patches;
    for (Topology::Patch& patch : limit_surface(cage, scheme).topology.patches)
        patches.push_back(std::move(patch.surface));
    return glue(std::move(patches), {.crease_angle = 0.05});
}

}  // namespace

TEST_CASE("The curves of a cage are those that gluing finds", "[property]") {
    Cage creased = cube();
    creased.creases = {{{0, 1}, 10}, {{1, 3}, 10}, {{3, 2}, 10}, {{2, 0}, 10}};
    Cage open = torus(5, 4);
    open.faces.resize(13);
    for (const auto& [cage, scheme] : {std::pair(cube(), SubdivisionScheme::CatmullClark),
                                       {creased, SubdivisionScheme::CatmullClark},
                                       {open, SubdivisionScheme::CatmullClark},
                                       {prism(5), SubdivisionScheme::CatmullClark},
                                       {triangles(), SubdivisionScheme::Loop}}) {
        const SurfaceModel by_cage(limit_surface(cage, scheme).topology), by_place = glued(cage, scheme);
        CHECK(by_cage.curves().size() == by_place.curves().size());
        CHECK(by_cage.vertices().size() == by_place.vertices().size());
        CHECK(by_cage.num_components() == by_place.num_components());
        for (const CurveKind kind : {CurveKind::Boundary, CurveKind::Smooth, CurveKind::Crease, CurveKind::Pole})
            CHECK(count(by_cage, kind) == count(by_place, kind));
        for (std::size_t c = 0; c < by_cage.curves().size(); ++c)
            if (by_cage.curves()[c].uses.size() == 2)
                for (const double t : {0.0, 0.3, 1.0})
                    CHECK((by_cage.position(by_cage.on_curve(static_cast<int>(c), 0, t)) -
                           by_cage.position(by_cage.on_curve(static_cast<int>(c), 1, t)))
                              .norm() <= 1e-7 * by_cage.diagonal());
    }
}

TEST_CASE("Borders of labels are kept, though the surface is smooth there", "[exact]") {
    Cage cage = cube();
    cage.labels = {1, 1, 1, 1, 1, 2};
    const SurfaceModel model = model_of(cage);
    CHECK(count(model, CurveKind::Crease) == 4);
    CHECK(count(model, CurveKind::Smooth) == 8);
    for (const ModelVertex& vertex : model.vertices()) CHECK_FALSE(vertex.tip);
}

TEST_CASE("A cage whose faces touch in a vertex only is refused", "[exact]") {
    Cage cage = cube();
    const int n = static_cast<int>(cage.points.size());
    cage.points.insert(cage.points.end(), {{3, 1, 1}, {3, 3, 1}, {1, 3, 1}});
    cage.faces.push_back({7, n, n + 1, n + 2});
    CHECK(why_no_limit_surface(cage) == "vertex 8: surfaces touch there without an edge");
}

TEST_CASE("Edges of a cage are sharpened by angle, and sharp corners are tips", "[exact]") {
    Cage cage = cube();
    sharpen(cage, 1.5);
    CHECK(cage.creases.size() == 12);
    CHECK(count(model_of(cage), CurveKind::Crease) == 12);
    cage = cube();
    sharpen(cage, 1.6);
    CHECK(cage.creases.empty());
    cage.corners = {{3, 10}};
    const SurfaceModel model = model_of(cage);
    int tips = 0;
    for (const ModelVertex& vertex : model.vertices()) {
        tips += vertex.tip;
        if (vertex.tip) CHECK((vertex.point - cage.points[3]).norm() < 1e-12);
    }
    CHECK(tips == 1);
}

TEST_CASE("Near vertices where curvature has no bound it is that at an eighth of the face", "[exact]") {
    const LimitSurface surface = limit_surface(prism(5));
    for (std::size_t i = 0; i < surface.face.size(); ++i) {
        if (surface.face[i] != 5) continue;  // the pentagon below: its middle has five edges
        const ParametricSurface& patch = *surface.topology.patches[i].surface;
        const auto from_jet = [&](double t) {
            const PrincipalCurvatures k = principal_curvatures(patch.jet2({1 - t, 1 - t}));
            return 1 / std::max(std::abs(k.k1), std::abs(k.k2));
        };
        CHECK(from_jet(0.001) < 0.8 * from_jet(0.1));
        const double middle = minimal_radius(patch, {1, 1});
        CHECK(middle > 0.8 * from_jet(0.1));
        for (const double t : {0.001, 0.01, 0.05}) CHECK(minimal_radius(patch, {1 - t, 1 - t}) == Approx(middle));
        CHECK(minimal_radius(patch, {0.7, 0.6}) ==
              Approx(1 / std::max(std::abs(principal_curvatures(patch.jet2({0.7, 0.6})).k1),
                                  std::abs(principal_curvatures(patch.jet2({0.7, 0.6})).k2))));
    }
}
