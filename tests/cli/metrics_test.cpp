// The program on metrics: adapt, metric, grade, quad and the planar examples.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "support/files.hpp"
#include "support/program.hpp"

using namespace gradus;
using support::Outcome;
using support::run;
using support::TemporaryFolder;

namespace {

const std::string kSquare = "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n4 1\n1 1 2 1\n2 2 3 2\n3 3 4 3\n4 4 1 4\n0\n";

void write_values(const std::string& path, const TriangleSoup& mesh, double (*f)(const Eigen::Vector3d&)) {
    std::ostringstream text;
    text.precision(17);
    text << "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n" << mesh.points.size() << "\n1 1\n";
    for (const Eigen::Vector3d& p : mesh.points) text << f(p) << '\n';
    text << "End\n";
    support::spill(path, text.str());
}

std::string last_line(const std::string& text) {
    const auto end = text.find_last_not_of('\n');
    const auto begin = text.rfind('\n', end);
    return text.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

}  // namespace

TEST_CASE("adapt meshes by formula, and leaves the map and its background", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.poly", kSquare);
    const Outcome outcome = run(folder,
                                "adapt square.poly --metric \"h = .01 + .2*abs(y-.5); 1, 0, .2, h\" --shock 1.5 "
                                "-o a.mesh -o a.vtu --map map.sol --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const auto json = nlohmann::json::parse(outcome.out);
    CHECK(json["converged"] == true);
    CHECK(json["iterations"].back()["own"]["unit_share"] > .95);
    const TriangleSoup mesh = read_mesh(folder / "a.mesh");
    CHECK(mesh.dimension == 2);
    CHECK(mesh.triangles.size() == json["triangles"]);
    const MeshData vtu = read_mesh_data(folder / "a.vtu");
    REQUIRE(vtu.point_fields.size() == 2);
    CHECK(vtu.point_fields[1].components == 9);
    const auto metrics = read_metrics(folder / "map.sol", read_mesh(folder / "map.mesh").points.size());
    CHECK(metrics.size() > 4);
}

TEST_CASE("A loop that does not end well says so, and leaves its last mesh", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.poly", kSquare);
    const Outcome outcome =
        run(folder, "adapt square.poly --size \"abs(x-.5) < .01 ? .005 : .5\" --no-gradation --iterations 1 -o a.mesh");
    CHECK(outcome.code == 1);
    CHECK(outcome.err.find("does NOT satisfy what is wanted after 1 iteration") != std::string::npos);
    CHECK(read_mesh(folder / "a.mesh").triangles.size() > 1000);
}

TEST_CASE("Formulas that make no sense are one line each", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.poly", kSquare);
    for (const auto& [options, message] : std::vector<std::pair<std::string, std::string>>{
             {"--size \"1/(x\"", "column 5"},
             {"--size \"q\"", "\"q\" is not known"},
             {"--size \"x - 2\"", "is no size"},
             {"--metric \"1, 2, 1\"", "not positive definite"},
             {"--metric \"1, 2\"", "2 results"},
             {"--size .1 --metric \"1,0,1\"", "--size"},
             {"", "--metric"},
             {"--metric \"1,0,1\" --method full2", "shape, paper, metric"}}) {
        CAPTURE(options);
        const Outcome outcome = run(folder, "adapt square.poly " + options + " -o out.mesh");
        CHECK(outcome.code != 0);
        CHECK(outcome.err.find(message) != std::string::npos);
        CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
        CHECK_FALSE(std::ifstream(folder / "out.mesh").good());
    }
}

TEST_CASE("From a solution to a metric to a mesh whose error is the one asked for", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.poly", kSquare);
    REQUIRE(run(folder, "adapt square.poly --size .05 -o start.mesh").code == 0);
    const auto field = [](const Eigen::Vector3d& p) { return p.x() * p.x() + 20 * p.y() * p.y(); };
    write_values(folder / "u.sol", read_mesh(folder / "start.mesh"), field);
    REQUIRE(run(folder, "metric u.sol start.mesh --error .02 --hmax 2 -o m.sol").code == 0);
    const Outcome outcome = run(folder, "adapt start.mesh --metric m.sol -o end.mesh");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const TriangleSoup mesh = read_mesh(folder / "end.mesh");
    // Largest error of linear interpolation in each triangle, at its middle and on its edges.
    double sum = 0, most = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Eigen::Vector3d &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
        double worst = std::abs((field(p) + field(q) + field(r)) / 3 - field((p + q + r) / 3));
        for (const auto& [s, t] : {std::pair{p, q}, std::pair{q, r}, std::pair{r, p}})
            worst = std::max(worst, std::abs((field(s) + field(t)) / 2 - field((s + t) / 2)));
        sum += worst / static_cast<double>(mesh.triangles.size());
        most = std::max(most, worst);
    }
    CHECK(sum < .02);
    CHECK(most < .03);
    CHECK(sum > .005);
    CHECK(run(folder, "metric u.sol start.mesh -o m.sol").code != 0);
    CHECK(run(folder, "metric start.mesh --error 1 -o m.sol").err.find("no field") != std::string::npos);
    CHECK(run(folder, "metric u.sol end.mesh --error 1 -o m.sol").code != 0);
}

TEST_CASE("grade takes metrics, and proves what it did", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.poly", kSquare);
    REQUIRE(run(folder, "adapt square.poly --metric \"1, 0, .02 + .5*abs(x-.5), .3\" --shock 4 -o a.mesh --map m.sol")
                .code == 0);
    for (const std::string method : {"shape", "metric", "mixed", "paper"}) {
        CAPTURE(method);
        const Outcome outcome =
            run(folder, "grade m.mesh --size m.sol --shock 1.3 --method " + method + " -o g.sol --json");
        CAPTURE(outcome.err);
        const auto json = nlohmann::json::parse(outcome.out);
        CHECK(outcome.code == 0);
        CHECK(json["met"] == true);
        if (method != "paper") CHECK(json["certificate"] == true);
        if (method != "mixed") CHECK(json["after"]["shock_max"] <= 1.3 * (1 + 1e-9));
        CHECK(read_metrics(folder / "g.sol").size() == json["vertices"]);
    }
    support::spill(folder / "bad.sol", "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n1\n1 3\n1 2 1\nEnd\n");
    support::spill(
        folder / "one.mesh",
        "MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 0\n1 0 0\n0 1 0\nTriangles\n1\n1 2 3 0\nEnd\n");
    const std::string bad = run(folder, "grade one.mesh --size bad.sol --shock 1.3 -o g.sol").err;
    CHECK(bad.find("bad.sol") != std::string::npos);
    CHECK_THROWS_WITH(read_metrics(folder / "bad.sol"),
                      Catch::Contains("bad.sol:6") && Catch::Contains("vertex 1 is not positive definite"));
}

TEST_CASE("Metrics come back from files as they went", "[io]") {
    const TemporaryFolder folder;
    const std::vector<Tensor> planar{planar_tensor(4, 1, 2), planar_tensor(1e6, 0, 1e-3)};
    const std::vector<Tensor> space{{{4, 1, 2, .5, .25, 3}}, round_metric(.1)};
    for (const std::string name : {"m.sol", "m.solb"}) {
        write_metrics(folder / name, planar, 2);
        CHECK(read_metrics(folder / name, 2) == planar);
        write_metrics(folder / name, space);
        CHECK(read_metrics(folder / name, 2) == space);
        CHECK_THROWS(read_metrics(folder / name, 3));
        write_sizes(folder / name, std::vector<double>{.5, 2});
        CHECK(read_metrics(folder / name) == std::vector<Tensor>{round_metric(.5), round_metric(2)});
    }
}

TEST_CASE("quad leaves no triangle where their number is even, and says where it is odd", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.poly", kSquare);
    REQUIRE(run(folder, "adapt square.poly --size .05 -o a.mesh").code == 0);
    const bool is_even = read_mesh(folder / "a.mesh").triangles.size() % 2 == 0;
    const Outcome outcome = run(folder, "quad a.mesh --all -o q.mesh -o q.vtu -o q.obj -o q.off --json");
    CHECK(outcome.code == (is_even ? 0 : 1));
    const auto json = nlohmann::json::parse(outcome.out);
    CHECK(json["triangles"] == (is_even ? 0 : 1));
    CHECK(json["worst"] > .3);
    CHECK(json["mean"] > .87);
    if (!is_even) CHECK(outcome.err.find("odd") != std::string::npos);
    // Read back as fans: two triangles for each.
    for (const std::string name : {"q.mesh", "q.vtu", "q.obj", "q.off"})
        CHECK(read_mesh(folder / name).triangles.size() ==
              2 * json["quads"].get<std::size_t>() + json["triangles"].get<std::size_t>());
    CHECK(run(folder, "quad a.mesh --refine -o r.mesh").code == 0);
    CHECK(run(folder, "quad a.mesh -o r.stl").code == 2);
    CHECK(last_line(run(folder, "quad nothing.mesh -o r.mesh").err).find("nothing.mesh") != std::string::npos);
}
