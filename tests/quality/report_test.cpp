#include "gradus/quality/report.hpp"

#include "quality/surfaces.hpp"

#include <catch2/catch.hpp>
#include <sstream>

using namespace gradus;
using namespace gradus::testing;

TEST_CASE("what is not given is not measured", "[quality]") {
    const Mesh mesh = torus(20, 10);
    const MeshReport report = measure(mesh.view());
    CHECK(report.topology.genus == 1);
    CHECK_FALSE(report.edges.has_value());
    CHECK_FALSE(report.distance.has_value());
    CHECK_FALSE(report.normals.has_value());
}

TEST_CASE("the text of a report names what was measured and stays narrow", "[quality]") {
    const SurfaceModel model = model_of(make_sphere({0, 0, 0}, 1));
    const PlacedTriangles mesh = mesh_of(model, 16, 8);
    const std::vector<double> sizes(mesh.points.size(), .4);
    MeshReport report =
        measure(mesh.view(), {.sizes = sizes, .model = &model, .places = mesh.places, .patches = mesh.patches});
    report.stages.push_back({"remesh", 1.25});
    const std::string text = to_text(report);
    for (const char* part :
         {"oriented manifold, closed", "genus 0", "area-length", "inradius-edge", "radius ratio", "metric length",
          "H-shock", "edge midpoints", "angle to the normal", "valence", "remesh", "|###"})
        CHECK_THAT(text, Catch::Contains(part));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        CHECK(line.size() <= 110);
        CHECK(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; }));
    }
}

TEST_CASE("the text of an empty mesh and of a broken one can be made", "[quality]") {
    CHECK_FALSE(to_text(measure({})).empty());
    const Mesh broken{{{0, 0, 0}, {0, 0, 0}, {std::nan(""), 0, 0}}, {{0, 1, 2}, {0, 0, 1}}};
    const std::string text = to_text(measure(broken.view()));
    CHECK_THAT(text, Catch::Contains("NOT an oriented manifold") && Catch::Contains("name a vertex twice") &&
                         Catch::Contains("not finite"));
}

TEST_CASE("a size map in space is preferred to sizes at vertices", "[quality]") {
    const Mesh mesh = square(4);
    const std::vector<double> sizes(mesh.points.size(), 100.);
    const MeshReport report =
        measure(mesh.view(), {.sizes = sizes, .size = [](const Eigen::Vector3d&, int&) { return .25; }});
    REQUIRE(report.edges.has_value());
    CHECK(report.edges->length.min == Approx(1));
    CHECK(report.edges->unit_share == 1);
}
