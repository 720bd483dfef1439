// The program on cages of subdivision surfaces.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/files.hpp"
#include "support/program.hpp"

using namespace gradus;
using nlohmann::json;
using support::Outcome;
using support::run;
using support::TemporaryFolder;

namespace {

const std::string kCube =
    "v -1 -1 -1\nv -1 -1 1\nv -1 1 -1\nv -1 1 1\nv 1 -1 -1\nv 1 -1 1\nv 1 1 -1\nv 1 1 1\n"
    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";

}  // namespace

TEST_CASE("the limit surface of a cage is meshed, its vertices on it, its creases kept", "[cli]") {
    const TemporaryFolder folder;
    support::spill(
        folder / "cage.obj",
        kCube + "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 3 10\nt crease 2/1/0 3 2 10\nt crease 2/1/0 2 0 10\n");
    const Outcome outcome = run(folder, "remesh cage.obj --subdivision catmull-clark -o out.mesh --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["area_length"]["min"].get<double>() > 0.8);
    CHECK(said["area_length"]["mean"].get<double>() > 0.97);
    const TriangleSoup mesh = read_mesh(folder / "out.mesh");
    CHECK(diagnose(mesh).closed);
    CHECK(mesh.edges.size() > 12);  // around one face
    const Outcome report = run(folder, "report out.mesh --reference cage.obj --subdivision catmull-clark --json");
    REQUIRE(report.code == 0);
    CHECK(json::parse(report.out)["distance"]["vertices"]["max"].get<double>() < 1e-12);
    CHECK(run(folder, "sizemap cage.obj --subdivision catmull-clark -o map.sol").code == 0);
}

TEST_CASE("angles of the cage make creases, and other files are no cages", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "cage.obj", kCube);
    REQUIRE(
        run(folder, "remesh cage.obj --subdivision catmull-clark --cage-crease-angle 80 -o out.mesh --hmax 0.2").code ==
        0);
    const TriangleSoup mesh = read_mesh(folder / "out.mesh");
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        area += (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm() / 2;
    CHECK(area == Approx(24).epsilon(1e-9));  // the cube itself
    const Outcome info = run(folder, "info cage.obj --subdivision catmull-clark");
    CHECK(info.code == 0);
    CHECK_THAT(info.out, Catch::Contains("8 vertices, 12 edges, 6 faces") && Catch::Contains("6 of 4 corners") &&
                             Catch::Contains("8 of 3 edges") && Catch::Contains("has a limit surface"));
    CHECK_THAT(run(folder, "info cage.obj --subdivision loop").out,
               Catch::Contains("NO limit surface") && Catch::Contains("face 1 has 4 corners"));
    // Materials are labels.
    std::string two = kCube;
    two.insert(two.find("f 5"), "usemtl b\n");
    two.insert(two.find("f 1 2"), "usemtl a\n");
    support::spill(folder / "two.obj", two);
    REQUIRE(
        run(folder, "remesh two.obj --subdivision catmull-clark -o two.mesh -o two.msh -o two.vtu -o two.ply").code ==
        0);
    for (const char* name : {"two.mesh", "two.msh", "two.vtu", "two.ply"}) {
        CAPTURE(name);
        const TriangleSoup labelled = read_mesh(folder / name);
        const auto ones = std::count(labelled.labels.begin(), labelled.labels.end(), 1),
                   twos = std::count(labelled.labels.begin(), labelled.labels.end(), 2);
        CHECK(ones + twos == std::ssize(labelled.triangles));
        CHECK(static_cast<double>(twos) / static_cast<double>(ones) == Approx(5).epsilon(0.1));
    }
    CHECK_THAT(run(folder, "remesh two.obj --subdivision catmull-clark -o two.stl").err,
               Catch::Contains("its labels are left behind, two.stl can hold none"));
    const std::pair<const char*, const char*> refused[] = {
        {"remesh cage.off --subdivision catmull-clark -o out.mesh", "is no .obj"},
        {"remesh cage.obj --cage-crease-angle 80 -o out.mesh", "give --subdivision too"},
        {"remesh cage.obj --subdivision catmull-clark --freeze 3 -o out.mesh", "--freeze"},
        {"remesh edit.obj --subdivision catmull-clark -o out.mesh", "edit.obj:15: the tag vertexedit is not supported"},
        {"remesh large.obj --subdivision catmull-clark -o out.mesh", "large.obj:15: a whole number is out of range"},
        {"remesh fan.obj --subdivision catmull-clark -o out.mesh", "edge 1-2 has 3 faces"},
        {"remesh tag.obj --subdivision catmull-clark -o out.mesh", "crease 1-8 is no edge"},
    };
    support::spill(folder / "cage.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    support::spill(folder / "edit.obj", kCube + "t vertexedit 2/3/2 0 1 0 0 1 a b\n");
    support::spill(folder / "large.obj", kCube + "t crease 2/1/0 0 4294967297 3\n");
    support::spill(folder / "fan.obj", kCube + "f 2 1 7\n");
    support::spill(folder / "tag.obj", kCube + "t crease 2/1/0 0 7 3\n");
    for (const auto& [command, message] : refused) {
        const Outcome outcome = run(folder, command);
        CAPTURE(command);
        CHECK(outcome.code != 0);
        CHECK_THAT(outcome.err, Catch::Contains(message));
    }
}

TEST_CASE("a chord error is kept between mesh and limit surface, and told as it was asked for", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "cage.obj", kCube);
    const Outcome outcome =
        run(folder, "remesh cage.obj --subdivision catmull-clark --chord-error 0.005 -o out.mesh --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["chord_error_kept"] == true);
    CHECK(said["distance"]["from_input"]["bound"].get<double>() <= 0.005);
    CHECK(said["distance"]["from_mesh"]["bound"].get<double>() <= 0.005);
    CHECK(said["sizing"]["value"] == 0.005);
    // Elements that may not be smaller cannot keep it: said, with the mesh written.
    const Outcome coarse =
        run(folder, "remesh cage.obj --subdivision catmull-clark --chord-error 0.001 --hmin 0.3 -o coarse.mesh");
    CHECK(coarse.code == 1);
    CHECK_THAT(coarse.err, Catch::Contains("farther from it than the chord error") && Catch::Contains("--hmin 0.3"));
    CHECK(diagnose(read_mesh(folder / "coarse.mesh")).closed);
}

TEST_CASE("a sharp corner on a straight crease is a vertex of the mesh", "[cli]") {
    const TemporaryFolder folder;
    // Four squares, a crease along their middle line, its middle vertex a corner.
    std::string cage;
    for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
            cage += "v " + std::to_string(i) + " " + std::to_string(j) + " " + (j == 1 ? "0.5" : "0") + "\n";
    cage += "f 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n";
    cage += "t crease 2/1/0 3 4 10\nt crease 2/1/0 4 5 10\nt corner 1/1/0 4 10\n";
    support::spill(folder / "cage.obj", cage);
    REQUIRE(run(folder, "remesh cage.obj --subdivision catmull-clark --hmax 0.37 -o out.mesh").code == 0);
    const TriangleSoup mesh = read_mesh(folder / "out.mesh");
    double nearest = 1;
    for (const Eigen::Vector3d& p : mesh.points) nearest = std::min(nearest, (p - Eigen::Vector3d(1, 1, 0.5)).norm());
    CHECK(nearest < 1e-12);
}
