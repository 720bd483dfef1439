#include "../../src/remesh/place_vertices.hpp"

#include "gradus/remesh/curves.hpp"
#include "remesh/judged.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;

namespace {

// What a mesh of patches begins with.
struct Start {
    models::Kind kind;
    SurfaceModel model;
    SizedBackground sized;
    ControlSpace control;
    PatchSupport support;
    CutCurves curves;
    PatchMeshes assembly;
    std::vector<Vertex> vertices;

    explicit Start(const models::Kind& of)
        : kind(of),
          model(kind.make()),
          sized(uniform_background(model, kind.size)),
          control(sized.background, sized.sizes),
          support(model),
          curves(model, discretise_curves(model, control)),
          assembly(model, curves,
                   [this](const SurfacePoint& at, const Eigen::Vector3d& point, int& hint) {
                       if (hint < 0) hint = control.locate(at);
                       return control.size(point, hint);
                   }),
          vertices(place_vertices(model, support, control, curves, assembly)) {}
};

}  // namespace

TEST_CASE("Vertices that divide a crease have the normal between its sides, and their lean", "[remesh][exact]") {
    for (const double angle : {0.6, 1.0, 2.0}) {
        CAPTURE(angle);
        const Start start(
            {.name = "hinge", .make = [=] { return models::model_of(models::hinge(angle)); }, .size = 0.1});
        int on_crease = 0, ends = 0;
        for (const Vertex& v : start.vertices) {
            // The hinge is the y axis.
            const bool on_axis = std::hypot(v.p.x(), v.p.z()) < 1e-12;
            if (!on_axis) {
                CHECK(v.lean == 1);
            } else if (v.bound == Bound::Fixed) {
                ++ends;
                CHECK(v.lean == kAnyNormal);
            } else {
                ++on_crease;
                CHECK(v.bound == Bound::Curve);
                CHECK(v.lean == Approx(std::cos(angle / 2)).epsilon(1e-6));
                for (const auto& use : start.model.curves()[v.place.curve].uses)
                    CHECK(v.n.dot(start.model.normal({use.patch, use.image->uv(v.place.t)})) ==
                          Approx(std::cos(angle / 2)).epsilon(1e-9));
            }
        }
        CHECK(on_crease == 9);
        CHECK(ends == 2);
    }
}

TEST_CASE("Vertices of every model know their place, and those on creases lean as far as both sides",
          "[remesh][property]") {
    for (const models::Kind& kind : models::zoo()) {
        CAPTURE(kind.name);
        const Start start(kind);
        int leaning = 0;
        for (std::size_t i = 0; i < start.vertices.size(); ++i) {
            const Vertex& v = start.vertices[i];
            CAPTURE(i);
            CHECK(v.p == start.model.position(v.place.at));
            CHECK(v.h == Approx(start.kind.size).epsilon(1e-3));
            CHECK((v.bound == Bound::Curve) == (v.place.curve >= 0));
            if (v.bound == Bound::Fixed) CHECK(start.model.vertices()[v.place.vertex].point == v.p);
            if (v.bound != Bound::Curve) {
                CHECK((v.lean == 1 || (v.bound == Bound::Fixed && v.lean == kAnyNormal)));
                continue;
            }
            const ModelCurve& curve = start.model.curves()[v.place.curve];
            if (curve.kind != CurveKind::Crease) {
                CHECK(v.lean == 1);
                continue;
            }
            ++leaning;
            for (const int use : {0, 1}) {
                const auto side = start.model.normal(start.model.on_curve(v.place.curve, use, v.place.t));
                CHECK(v.n.dot(side) == Approx(v.lean).epsilon(1e-6));
            }
        }
        CHECK((leaning > 0) == (kind.creases > 0));
    }
}

TEST_CASE("The middle of a piece of a crease leans as its ends do where the angle is the same", "[remesh][exact]") {
    const Start start({.name = "hinge", .make = [] { return models::model_of(models::hinge(1)); }, .size = 0.1});
    Connectivity mesh(start.assembly.num_vertices(), start.assembly.triangles());
    int crease = -1;
    for (int c = 0; c < static_cast<int>(start.model.curves().size()); ++c)
        if (start.model.curves()[c].kind == CurveKind::Crease) crease = c;
    REQUIRE(crease >= 0);
    std::vector<int> on_crease;
    for (int i = 0; i < static_cast<int>(start.curves.t[crease].size()); ++i)
        on_crease.push_back(start.curves.number(start.model, crease, i));
    for (std::size_t i = 0; i + 1 < on_crease.size(); ++i)
        mesh.set_tag(mesh.find_edge(on_crease[i], on_crease[i + 1]), start.support.chain_of(crease));
    Editor editor(start.support, start.control, start.vertices, mesh);
    // Between two that slide, and beside a corner.
    for (const std::size_t i : {std::size_t(0), std::size_t(4)}) {
        const int fresh = editor.split(editor.mesh().find_edge(on_crease[i], on_crease[i + 1]));
        REQUIRE(fresh >= 0);
        CHECK(editor.vertex(fresh).bound == Bound::Curve);
        CHECK(editor.vertex(fresh).lean == Approx(std::cos(0.5)).epsilon(1e-6));
    }
    const float before = editor.vertex(on_crease[2]).lean;
    editor.centre(on_crease[2], on_crease[1], on_crease[3]);
    CHECK(editor.vertex(on_crease[2]).lean == Approx(before).epsilon(1e-6));
}
