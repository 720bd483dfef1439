// The program with elements that are to stay as they are: from the file, by label and by a list.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/files.hpp"
#include "support/program.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using nlohmann::json;
using support::Outcome;
using support::run;
using support::TemporaryFolder;

namespace {

using Corner = std::array<double, 3>;

// The corners of required triangles, wherever they start.
std::set<std::set<Corner>> required_triangles(const TriangleSoup& soup) {
    std::set<std::set<Corner>> result;
    for (const int t : soup.required.triangles) {
        std::set<Corner> corners;
        for (const int v : soup.triangles[t])
            corners.insert({soup.points[v].x(), soup.points[v].y(), soup.points[v].z()});
        result.insert(corners);
    }
    return result;
}

std::set<std::set<Corner>> required_edges(const TriangleSoup& soup) {
    std::set<std::set<Corner>> result;
    for (const auto& edge : soup.required.edges) {
        std::set<Corner> corners;
        for (const int v : edge) corners.insert({soup.points[v].x(), soup.points[v].y(), soup.points[v].z()});
        result.insert(corners);
    }
    return result;
}

std::set<Corner> required_vertices(const TriangleSoup& soup) {
    std::set<Corner> result;
    for (const int v : soup.required.vertices)
        result.insert({soup.points[v].x(), soup.points[v].y(), soup.points[v].z()});
    return result;
}

TriangleSoup tin() {
    TriangleSoup soup = triangulations::soup(triangulations::capped_cylinder(40, 10, 1, 2, 4));
    // The caps and the side.
    for (const Triangle& t : soup.triangles) {
        const double low = std::min({soup.points[t[0]].z(), soup.points[t[1]].z(), soup.points[t[2]].z()});
        const double high = std::max({soup.points[t[0]].z(), soup.points[t[1]].z(), soup.points[t[2]].z()});
        soup.labels.push_back(high == 0 ? 1 : low == 2 ? 2 : 3);
    }
    return soup;
}

}  // namespace

TEST_CASE("what a Medit file requires is kept within the chord error, and marked for the next run", "[cli]") {
    const TemporaryFolder folder;
    const std::string out = GENERATE("out.mesh", "out.meshb");
    TriangleSoup soup = tin();
    const auto side = [&](int n) {
        for (int t = 0;; ++t)
            if (soup.labels[t] == 3 && n-- == 0) return t;
    };
    soup.required = {.vertices = {soup.triangles[side(100)][0], soup.triangles[side(300)][1]},
                     .edges = {{soup.triangles[side(50)][0], soup.triangles[side(50)][1]}},
                     .triangles = {side(200), side(201), side(7)}};
    write_mesh(folder / "in.mesh", soup);
    const Outcome outcome =
        run(folder, "remesh in.mesh -o " + out + " -o out.off --chord-error 0.01 --report r.json --json");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["required"] == json{{"vertices", 2}, {"edges", 1}, {"triangles", 3}});
    CHECK(said["chord_error_kept"] == true);
    CHECK(said["report"]["offenders"]["features_known"] == true);
    const TriangleSoup mesh = read_mesh(folder / out);
    CHECK(is_clean_manifold(diagnose(mesh)));
    CHECK(required_triangles(mesh) == required_triangles(soup));
    CHECK(required_edges(mesh) == required_edges(soup));
    CHECK(required_vertices(mesh) == required_vertices(soup));

    const Outcome again = run(folder, "remesh " + out + " -o twice.mesh --chord-error 0.02");
    CAPTURE(again.out, again.err);
    REQUIRE(again.code == 0);
    CHECK_THAT(again.out, Catch::Contains("frozen: 2 vertices, 1 edges, 3 triangles"));
    CHECK(required_triangles(read_mesh(folder / "twice.mesh")) == required_triangles(soup));
    CHECK(required_edges(read_mesh(folder / "twice.mesh")) == required_edges(soup));
    // Off files cannot say.
    CHECK_THAT(run(folder, "remesh in.mesh -o a.off").out, Catch::Contains("a.off does not mark them"));
    CHECK_THAT(run(folder, "info in.mesh").out, Catch::Contains("2 vertices, 1 edges and 3 triangles required"));
}

TEST_CASE("a label is frozen as a whole, with sizes given too, the same on any number of threads", "[cli]") {
    const TemporaryFolder folder;
    const TriangleSoup soup = tin();
    write_mesh(folder / "in.mesh", soup);
    write_sizes(folder / "h.sol", std::vector<double>(soup.points.size(), 0.08));
    for (const std::string sizing : {"--size h.sol", "--chord-error 0.004"}) {
        CAPTURE(sizing);
        const Outcome outcome = run(folder, "remesh in.mesh -o one.mesh --freeze 1 --freeze 2 --threads 1 " + sizing);
        CAPTURE(outcome.out, outcome.err);
        REQUIRE(outcome.code == 0);
        REQUIRE(run(folder, "remesh in.mesh -o two.mesh --freeze 2 --freeze 1 --threads 2 --quiet " + sizing).code ==
                0);
        TriangleSoup frozen = soup;
        for (int t = 0; t < static_cast<int>(soup.triangles.size()); ++t)
            if (soup.labels[t] != 3) frozen.required.triangles.push_back(t);
        const TriangleSoup one = read_mesh(folder / "one.mesh"), two = read_mesh(folder / "two.mesh");
        CHECK(required_triangles(one) == required_triangles(frozen));
        CHECK(one.points == two.points);
        CHECK(one.triangles == two.triangles);
        CHECK(is_clean_manifold(diagnose(one)));
        CHECK(diagnose(one).euler_characteristic == 2);
        for (const int t : one.required.triangles) CHECK(one.labels[t] != 3);
    }
    const Outcome unknown = run(folder, "remesh in.mesh -o a.mesh --freeze 5");
    CHECK(unknown.code == 1);
    CHECK_THAT(unknown.err, Catch::Contains("in.mesh: --freeze 5: no triangle has that label; its labels are 1, 2, 3"));
}

TEST_CASE("a list freezes elements of any format, before repair", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup soup = tin();
    soup.labels.clear();
    // Repair drops the first vertex and the first triangle, and turns another.
    soup.points.insert(soup.points.begin(), Eigen::Vector3d(7, 7, 7));
    for (Triangle& t : soup.triangles)
        for (int& v : t) ++v;
    soup.triangles.insert(soup.triangles.begin(), soup.triangles[30]);
    std::swap(soup.triangles[60][0], soup.triangles[60][1]);
    write_mesh(folder / "in.off", soup);
    const auto [a, b, c] = soup.triangles[300];
    support::spill(folder / "keep.txt", "# from 1 on\ntriangle 61\nedge " + std::to_string(a + 1) + " " +
                                            std::to_string(b + 1) + "  # a side\n\nvertex " + std::to_string(c + 1) +
                                            "\n");
    const Outcome outcome = run(folder, "remesh in.off -o out.mesh --freeze-list keep.txt --repair --chord-error 0.02");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    soup.required = {.vertices = {c}, .edges = {{a, b}}, .triangles = {60}};
    const TriangleSoup mesh = read_mesh(folder / "out.mesh");
    CHECK(required_triangles(mesh) == required_triangles(soup));
    CHECK(required_edges(mesh) == required_edges(soup));
    CHECK(required_vertices(mesh) == required_vertices(soup));
}

TEST_CASE("demands that cannot be met are refused in one line with file and place", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const auto refused = [&](const std::string& arguments, const std::string& what) {
        const Outcome outcome = run(folder, "remesh " + arguments + " -o out.mesh");
        CAPTURE(arguments, outcome.err);
        CHECK(outcome.code != 0);
        CHECK_THAT(outcome.err, Catch::Contains(what));
        CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
        CHECK_FALSE(std::filesystem::exists(folder / "out.mesh"));
    };
    const auto list = [&](const std::string& text, const std::string& what) {
        support::spill(folder / "keep.txt", text);
        refused("in.off --freeze-list keep.txt", what);
    };
    list("vertex 1\nvertex 0\n", "keep.txt:2: index out of range: vertex 0");
    list("triangle 99999\n", "keep.txt:1: index out of range: triangle 99999");
    list("edge 3\n", "keep.txt:1: expected the number of a vertex");
    list("edge 3 x\n", "keep.txt:1: expected the number of a vertex, found 'x'");
    list("\nface 3\n", "keep.txt:2: expected vertex, edge or triangle, found 'face'");
    list("vertex 3 4\n", "keep.txt:1: expected the end of the line, found '4'");
    list("edge 1 400\n", "in.off: required edge 0-399");
    refused("in.off --freeze-list missing.txt", "missing.txt");
    refused("in.off --freeze 1", "no triangle has that label; there are none");
    support::spill(folder / "bad.mesh",
                   "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n2 0 0 0\n1 1 0 0\n1 -1 0 0\n"
                   "Triangles\n3\n1 2 4 0\n2 3 4 0\n1 3 2 0\nRequiredTriangles\n1\n3\nEnd\n");
    refused("bad.mesh", "bad.mesh: required triangle 2 (counted from 0) at 0 0 0 has no area");
    support::spill(folder / "worse.mesh",
                   "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n0 1 0 0\nTriangles\n1\n1 2 3 "
                   "0\nRequiredTriangles\n1\n2\nEnd\n");
    refused("worse.mesh", "worse.mesh:13: index out of range: triangle 2; there are 1");
    support::spill(folder / "a.bpt", "1\n3 3\n");
    refused("a.bpt --freeze 1", "--freeze is for triangle meshes");
}
