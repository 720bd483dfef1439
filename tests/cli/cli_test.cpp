// The program as its users meet it: what it writes, what it says, and how it fails.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gradus/gradation/measures.hpp"
#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/files.hpp"
#include "support/program.hpp"

using nlohmann::json;
using support::Outcome;
using support::run;
using support::spill;
using support::TemporaryFolder;

namespace {

bool exists(const std::string& path) { return std::filesystem::exists(path); }

// A bicubic hill over a square of side 3, round at the top, flat outside.
std::string hill() {
    std::ostringstream text;
    text << "# a hill\n1\n3 3\n";
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i)
            text << i << ' ' << j << ' ' << ((i == 1 || i == 2) && (j == 1 || j == 2) ? 2 : 0) << '\n';
    return text.str();
}

std::string with_line(const std::string& text, int line, const std::string& replacement) {
    std::istringstream in(text);
    std::string result;
    int number = 0;
    for (std::string old; std::getline(in, old);) result += (++number == line ? replacement : old) + "\n";
    return result;
}

const std::string kCoarse = " --hmin 0.05 --hmax 0.5 ";

// The folder every test starts from: hill.bpt, its size map and background.
struct Hill {
    TemporaryFolder folder;
    Hill() {
        spill(folder / "hill.bpt", hill());
        REQUIRE(run(folder, "sizemap hill.bpt -o raw.sol --background bg.mesh -q" + kCoarse).code == 0);
    }
};

// One line on standard error that names the fault; nothing else anywhere.
void check_failure(const Outcome& outcome, int code, const std::string& part) {
    CAPTURE(outcome.err, outcome.out);
    CHECK(outcome.code == code);
    CHECK(outcome.err.rfind("gradus: error: ", 0) == 0);
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    CHECK_THAT(outcome.err, Catch::Contains(part));
    CHECK(outcome.out.empty());
}

}  // namespace

TEST_CASE("help and version succeed, and each command has its help", "[cli]") {
    const TemporaryFolder folder;
    CHECK(run(folder, "--help").code == 0);
    CHECK_THAT(run(folder, "--version").out, Catch::StartsWith("gradus "));
    for (const char* command : {"teapot", "sizemap", "grade", "remesh", "report", "info"}) {
        const Outcome help = run(folder, std::string(command) + " --help");
        CHECK(help.code == 0);
        CHECK_THAT(help.out, Catch::Contains("--json") && Catch::Contains("--threads") && Catch::Contains("--quiet"));
        CHECK(help.err.empty());
    }
}

TEST_CASE("sizemap writes one size per vertex of a background that lies on the surface", "[cli]") {
    const Hill hill;
    const gradus::TriangleSoup soup = gradus::read_mesh(hill.folder / "bg.mesh");
    const std::vector<double> sizes = gradus::read_sizes(hill.folder / "raw.sol", soup.points.size());
    CHECK(*std::min_element(sizes.begin(), sizes.end()) >= 0.05);
    CHECK(*std::max_element(sizes.begin(), sizes.end()) <= 0.5);
    CHECK(soup.parameters.size() >= soup.points.size());

    SECTION("and reads a background that is there") {
        const std::string before = gradus::read_file(hill.folder / "bg.mesh");
        REQUIRE(run(hill.folder, "sizemap hill.bpt -o again.sol --background bg.mesh --alpha 0.6 -q" + kCoarse).code ==
                0);
        CHECK(gradus::read_file(hill.folder / "bg.mesh") == before);
        const std::vector<double> twice = gradus::read_sizes(hill.folder / "again.sol", soup.points.size());
        for (std::size_t v = 0; v < sizes.size(); ++v) CHECK(twice[v] >= sizes[v]);
    }
    SECTION("and writes the background beside the map where none is named") {
        REQUIRE(run(hill.folder, "sizemap hill.bpt -o other.sol -q" + kCoarse).code == 0);
        CHECK(gradus::read_mesh(hill.folder / "other.mesh").points.size() == soup.points.size());
    }
}

TEST_CASE("grade keeps its bound, by every method, and says so to machines", "[cli]") {
    const Hill hill;
    const gradus::TriangleSoup soup = gradus::read_mesh(hill.folder / "bg.mesh");
    const gradus::TriMesh mesh = gradus::to_mesh(soup);
    const std::string method = GENERATE("full", "exact", "gradient", "paper");
    const Outcome outcome =
        run(hill.folder, "grade bg.mesh --size raw.sol --shock 1.3 --json -o graded.sol --method " + method);
    CAPTURE(method, outcome.err);
    CHECK(outcome.code == 0);
    const json said = json::parse(outcome.out);
    const gradus::GradationReport after =
        gradus::measure_gradation(mesh, gradus::read_sizes(hill.folder / "graded.sol", soup.points.size()));
    CHECK(said["method"] == method);
    CHECK(said["met"] == true);
    CHECK(said["after"]["shock_max"].get<double>() == Approx(after.shock_max));
    CHECK(said["before"]["shock_max"].get<double>() > 1.3);
    if (method != "gradient") CHECK(after.shock_max <= 1.3 * (1 + 1e-9));
    if (method == "full") CHECK(after.gradient_max <= std::log(1.3) * (1 + 1e-6));
    if (method == "exact")
        CHECK(said["certificate"] == true);
    else
        CHECK(said["certificate"].is_null());
}

TEST_CASE("a growth rate is a shock, and the variation bounds slopes", "[cli]") {
    const Hill hill;
    REQUIRE(run(hill.folder, "grade bg.mesh --size raw.sol --shock 1.2 -q -o shock.sol").code == 0);
    REQUIRE(run(hill.folder, "grade bg.mesh --size raw.sol --growth 1.2 -q -o growth.sol").code == 0);
    CHECK(gradus::read_file(hill.folder / "shock.sol") == gradus::read_file(hill.folder / "growth.sol"));
    REQUIRE(run(hill.folder, "grade bg.mesh --size raw.sol --growth 1.2 -q -o growth.pos").code == 0);
    CHECK_THAT(gradus::read_file(hill.folder / "growth.pos"), Catch::StartsWith("View \"size\" {\nST("));
    const json said =
        json::parse(run(hill.folder, "grade bg.mesh --size raw.sol --variation 0.1 --json -o raw.sol").out);
    CHECK(said["after"]["variation_max"].get<double>() <= 0.1 * (1 + 1e-9));
}

TEST_CASE("remesh writes every format it is asked for, on the surface and labelled", "[cli]") {
    const Hill hill;
    const Outcome outcome = run(hill.folder,
                                "remesh hill.bpt -o m.mesh -o m.meshb -o m.obj -o m.off -o m.ply -o m.stl -o m.vtu -o "
                                "m.msh --json --report r.json" +
                                    kCoarse);
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["files"].size() == 9);
    for (const std::string path : said["files"]) CHECK(exists(hill.folder / path));
    const gradus::TriangleSoup soup = gradus::read_mesh(hill.folder / "m.mesh");
    CHECK(said["triangles"] == soup.triangles.size());
    CHECK(std::all_of(soup.labels.begin(), soup.labels.end(), [](int label) { return label == 1; }));
    CHECK(gradus::is_clean_manifold(gradus::diagnose(soup)));
    for (const char* format : {"m.meshb", "m.msh", "m.obj", "m.off", "m.ply", "m.stl", "m.vtu"})
        CHECK(gradus::read_mesh(hill.folder / format).triangles.size() == soup.triangles.size());

    const json report = json::parse(gradus::read_file(hill.folder / "r.json"));
    for (const char* key : {"topology", "shape", "edges", "gradation", "distance", "normals", "stages"})
        CHECK(!report.at(key).is_null());
    CHECK(report["topology"]["triangles"] == soup.triangles.size());
    CHECK(report["distance"]["vertices"]["max"].get<double>() < 1e-12);
    CHECK(report["edges"]["unit_share"].get<double>() > 0.8);
}

TEST_CASE("remesh takes a size map as it is, or grades it", "[cli]") {
    const Hill hill;
    REQUIRE(run(hill.folder, "grade bg.mesh --size raw.sol --shock 1.5 -q -o graded.sol").code == 0);
    REQUIRE(run(hill.folder, "remesh hill.bpt --size graded.sol --background bg.mesh --no-gradation -q -o as_is.obj")
                .code == 0);
    REQUIRE(run(hill.folder, "remesh hill.bpt --size raw.sol --background bg.mesh --shock 1.5 -q -o graded.obj").code ==
            0);
    CHECK(gradus::read_file(hill.folder / "as_is.obj") == gradus::read_file(hill.folder / "graded.obj"));
}

TEST_CASE("remesh is the same for any number of threads", "[cli]") {
    const Hill hill;
    const std::string teapot = "remesh '" GRADUS_ASSETS "/teapot.bpt' --alpha 1 --hmin 0.1 --fast -q";
    REQUIRE(run(hill.folder, teapot + " --threads 1 -o one.obj").code == 0);
    REQUIRE(run(hill.folder, teapot + " --threads 2 -o two.obj").code == 0);
    CHECK(gradus::read_file(hill.folder / "one.obj") == gradus::read_file(hill.folder / "two.obj"));
}

TEST_CASE("a size prescribed at a point is met there", "[cli]") {
    const Hill hill;
    REQUIRE(run(hill.folder,
                "remesh hill.bpt --alpha 10 --hmax 0.5 --size-at 0,0,0=0.02 --size-at '3,3,0=0.03' -q -o m.obj")
                .code == 0);
    const gradus::TriangleSoup soup = gradus::read_mesh(hill.folder / "m.obj");
    const auto shortest_at = [&](const Eigen::Vector3d& p) {
        double shortest = 1e300;
        for (const gradus::Triangle& t : soup.triangles)
            for (int k = 0; k < 3; ++k)
                if ((soup.points[t[k]] - p).norm() < 1e-9)
                    shortest = std::min(shortest, (soup.points[t[(k + 1) % 3]] - p).norm());
        return shortest;
    };
    CHECK(shortest_at({0, 0, 0}) < 0.03);
    CHECK(shortest_at({3, 3, 0}) < 0.045);
}

TEST_CASE("report measures a mesh from elsewhere against surface and size map", "[cli]") {
    const Hill hill;
    REQUIRE(run(hill.folder, "remesh hill.bpt --size raw.sol --background bg.mesh -q -o m.obj -o m.mesh").code == 0);
    const std::string against = " --reference hill.bpt --size raw.sol --background bg.mesh --json";
    const json from_places = json::parse(run(hill.folder, "report m.mesh" + against).out);
    const Outcome outcome = run(hill.folder, "report m.obj -o r.html" + against);
    REQUIRE(outcome.code == 0);
    const json found = json::parse(outcome.out);
    CHECK(found["distance"]["vertices"]["max"].get<double>() < 1e-8);
    CHECK(found["edges"]["unit_share"].get<double>() == Approx(from_places["edges"]["unit_share"].get<double>()));
    CHECK(found["normals"]["angle"]["max"].get<double>() ==
          Approx(from_places["normals"]["angle"]["max"].get<double>()).epsilon(1e-6));
    CHECK_THAT(gradus::read_file(hill.folder / "r.html"),
               Catch::StartsWith("<!DOCTYPE html>") || Catch::StartsWith("<!doctype html>"));
    CHECK_THAT(run(hill.folder, "report m.obj").out, Catch::Contains("area-length"));
}

TEST_CASE("info tells patches, meshes and sizes apart", "[cli]") {
    const Hill hill;
    const json patches = json::parse(run(hill.folder, "info --json '" GRADUS_ASSETS "/teapot.bpt'").out);
    CHECK(patches["kind"] == "patches");
    CHECK(patches["patches"] == 32);
    CHECK(patches["components"] == 4);
    CHECK(patches["boundary_loops"] == 6);
    CHECK(patches["poles"] == 2);
    const json mesh = json::parse(run(hill.folder, "info --json bg.mesh").out);
    CHECK(mesh["kind"] == "mesh");
    CHECK(mesh["sound"] == true);
    CHECK(mesh["boundary_loops"] == 1);
    const json sizes = json::parse(run(hill.folder, "info --json raw.sol").out);
    CHECK(sizes["count"] == mesh["vertices"]);
    // A mesh that is no manifold is looked at all the same.
    spill(hill.folder / "fan.off", "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 -1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 1 4\n");
    const Outcome fan = run(hill.folder, "info fan.off");
    CHECK(fan.code == 0);
    CHECK_THAT(fan.out, Catch::Contains("NOT usable"));
    check_failure(run(hill.folder, "grade fan.off --size raw.sol --shock 2 -o x.sol"), 1,
                  "fan.off: not an oriented manifold");
}

TEST_CASE("faults of files are named with file and line, and nothing is written", "[cli]") {
    const Hill hill;
    const auto fails = [&](const std::string& name, const std::string& text, const std::string& part) {
        spill(hill.folder / name, text);
        check_failure(run(hill.folder, "remesh " + name + " -o x.obj"), 1, part);
        CHECK(!exists(hill.folder / "x.obj"));
    };
    fails("short.bpt", "2\n3 3\n0 0 0\n", "short.bpt:3: ");
    fails("word.bpt", with_line(::hill(), 6, "1 two 3"), "word.bpt:6: \"two\" is not a number");
    fails("nan.bpt", with_line(::hill(), 7, "nan 0 0"), "nan.bpt:7: \"nan\"");
    fails("empty.bpt", "", "empty.bpt");
    std::string flat = "1\n3 3\n";
    for (int i = 0; i < 16; ++i) flat += std::to_string(i) + " 0 0\n";
    fails("line.bpt", flat, "line.bpt: patch 0 has zero area");
    check_failure(run(hill.folder, "remesh missing.bpt -o x.obj"), 1, "missing.bpt: ");

    spill(hill.folder / "wrong.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n3\n1 1\n1\n1\n1\nEnd\n");
    check_failure(run(hill.folder, "grade bg.mesh --size wrong.sol --shock 2 -o x.sol"), 1, "wrong.sol:4: ");
    check_failure(run(hill.folder, "remesh hill.bpt --size wrong.sol --background bg.mesh -o x.obj"), 1,
                  "wrong.sol:4: ");
    spill(hill.folder / "far.bpt", with_line(::hill(), 4, "-9 0 0"));
    check_failure(run(hill.folder, "remesh far.bpt --size raw.sol --background fan.off -o x.obj"), 1, "fan.off");
    CHECK(!exists(hill.folder / "x.obj"));
    CHECK(!exists(hill.folder / "x.sol"));
}

TEST_CASE("options that make no sense are refused before anything is computed", "[cli]") {
    const Hill hill;
    const auto [arguments, part] = GENERATE(table<std::string, std::string>({
        {"remesh hill.bpt -o x.obj --shock 1", "--shock is 1"},
        {"remesh hill.bpt -o x.obj --shock nan", "--shock is nan"},
        {"remesh hill.bpt -o x.obj --growth 0.5", "--growth is 0.5"},
        {"remesh hill.bpt -o x.obj --growth 1.2 --shock 1.2", "--growth"},
        {"remesh hill.bpt -o x.obj --variation -1", "--variation is -1"},
        {"remesh hill.bpt -o x.obj --shock 2 --no-gradation", "--no-gradation"},
        {"remesh hill.bpt -o x.obj --method best", "full, exact, gradient, paper"},
        {"remesh hill.bpt -o x.obj --alpha 0", "--alpha is 0"},
        {"remesh hill.bpt -o x.obj --alpha -1", "--alpha is -1"},
        {"remesh hill.bpt -o x.obj --alpha nan", "--alpha is nan"},
        {"remesh hill.bpt -o x.obj --alpha many", "many"},
        {"remesh hill.bpt -o x.obj --alpha 1 --normal-angle 5", "--normal-angle"},
        {"remesh hill.bpt -o x.obj --normal-angle 200", "--normal-angle is 200"},
        {"remesh hill.bpt -o x.obj --relative-chord-error 2", "--relative-chord-error is 2"},
        {"remesh hill.bpt -o x.obj --chord-error inf", "--chord-error is inf"},
        {"remesh hill.bpt -o x.obj --hmin 1 --hmax 0.5", "--hmin is 1; it must be at most --hmax 0.5"},
        {"remesh hill.bpt -o x.obj --hmax 0", "--hmax is 0"},
        {"remesh hill.bpt -o x.obj --size-at 1,2=3", "--size-at"},
        {"remesh hill.bpt -o x.obj --size-at 1,2,3=-1", "--size-at"},
        {"remesh hill.bpt -o x.obj --threads 0", "--threads"},
        {"remesh hill.bpt -o x.obj --max-triangles 0", "--max-triangles"},
        {"remesh hill.bpt -o x.xyz", "unknown extension \".xyz\""},
        {"remesh hill.bpt -o x", "unknown extension"},
        {"remesh hill.bpt -o x.obj -o ./x.obj", "two outputs"},
        {"remesh hill.bpt -o x.obj --report r.txt", "r.txt: unknown extension"},
        {"remesh hill.bpt -o x.obj --background bg.mesh", "--background needs --size"},
        {"remesh hill.bpt -o x.obj --size raw.sol --alpha 1", "--size gives all sizes"},
        {"remesh hill.xyz -o x.obj", "hill.xyz: unknown extension"},
        {"remesh hill.bpt", "required"},
        {"grade bg.mesh --size raw.sol -o x.sol", "no bound is given"},
        {"grade bg.mesh --size raw.sol --shock 2 -o x.mesh", "unknown extension \".mesh\""},
        {"sizemap hill.bpt -o x.obj", "unknown extension \".obj\""},
        {"info hill.xyz", "unknown extension"},
        {"bogus", "bogus"},
        {"", "subcommand"},
    }));
    CAPTURE(arguments);
    check_failure(run(hill.folder, arguments), 2, part);
    CHECK(!exists(hill.folder / "x.obj"));
}

TEST_CASE("outputs that cannot be written are found before anything is computed", "[cli]") {
    const Hill hill;
    std::filesystem::create_directory(hill.folder.path() / "folder.obj");
    check_failure(run(hill.folder, "remesh missing.bpt -o nowhere/x.obj"), 1, "there is no folder nowhere");
    check_failure(run(hill.folder, "remesh missing.bpt -o folder.obj"), 1, "folder.obj: is a folder");
    check_failure(run(hill.folder, "remesh missing.bpt -o x.obj --report nowhere/r.html"), 1,
                  "there is no folder nowhere");
    check_failure(run(hill.folder, "remesh missing.bpt -o x.obj --pictures hill.bpt"), 1,
                  "hill.bpt: this folder cannot be made");
    check_failure(run(hill.folder, "sizemap missing.bpt -o x.sol --background nowhere/bg.mesh"), 1,
                  "there is no folder nowhere");
    check_failure(run(hill.folder, "grade missing.mesh --size raw.sol --shock 2 -o nowhere/x.sol"), 1,
                  "there is no folder nowhere");
    check_failure(run(hill.folder, "teapot --out hill.bpt/x"), 1, "cannot be made");
}

TEST_CASE("a map that asks for too many triangles is refused with the number", "[cli]") {
    const Hill hill;
    const Outcome outcome =
        run(hill.folder, "remesh hill.bpt -o x.obj --max-triangles 100 --size raw.sol --background bg.mesh");
    check_failure(outcome, 1, "raise --max-triangles");
    CHECK(!exists(hill.folder / "x.obj"));
    check_failure(run(hill.folder, "remesh hill.bpt -o x.obj --hmin 1e-9 --alpha 1e-9 --max-triangles 5000"), 1,
                  "raise --max-triangles");
}

TEST_CASE("quiet is quiet", "[cli]") {
    const Hill hill;
    const Outcome outcome = run(hill.folder, "remesh hill.bpt -o x.obj -q" + kCoarse);
    CHECK(outcome.code == 0);
    CHECK(outcome.out.empty());
    CHECK(outcome.err.empty());
}

TEST_CASE("teapot leaves everything it promises", "[cli]") {
    const TemporaryFolder folder;
    const Outcome outcome =
        run(folder, "teapot --alpha 1 --hmin 0.1 --hmax 1 --fast --iterations 1 --out made/here --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    for (const char* name : {"background.mesh", "raw.sol", "graded.sol", "raw.obj", "raw.mesh", "raw.vtu", "graded.obj",
                             "graded.mesh", "graded.vtu", "report.json", "report.html", "raw.png", "graded.png",
                             "enlargement-1.png", "enlargement-2.png", "size.png", "shock.png", "quality.png"})
        CHECK(exists(folder / (std::string("made/here/") + name)));
    CHECK(json::parse(gradus::read_file(folder / "made/here/report.json"))["graded"] == said["graded"]);
    for (const char* key : {"sizing", "background", "gradation", "raw", "graded", "paper", "stages", "files"})
        CHECK(said.contains(key));
    CHECK(said["gradation"]["after"]["shock_max"].get<double>() <= 1.5 * (1 + 1e-9));
    CHECK(said["graded"]["mesh"]["topology"]["components"] == 4);
    CHECK(said["graded"]["mesh"]["topology"]["boundary_loops"] == 6);
    CHECK(said["graded"]["adaption"]["iterations"].size() == 1);
    const std::size_t vertices = gradus::read_mesh(folder / "made/here/background.mesh").points.size();
    CHECK(gradus::read_sizes(folder / "made/here/graded.sol").size() == vertices);
}

TEST_CASE("info finds what is wrong with a mesh, and repairs it", "[cli]") {
    const TemporaryFolder folder;
    // A tetrahedron with a triangle turned round, another one twice, and a corner given twice; a triangle passes
    // through it.
    spill(folder / "bad.obj",
          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 1\nv .1 .1 -1\nv .1 .1 2\nv 3 3 3\n"
          "f 1 3 2\nf 1 4 2\nf 2 3 5\nf 1 4 3\nf 3 1 4\nf 6 7 8\n");
    const Outcome plain = run(folder, "info bad.obj");
    CHECK(plain.code == 0);
    CHECK_THAT(plain.out,
               Catch::Contains("NOT usable as it is") && Catch::Contains("pairs of triangles that touch or intersect"));

    const Outcome outcome = run(folder, "info bad.obj --repair -o good.obj");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.out, Catch::Contains("1 triangles turned round: 1") &&
                                Catch::Contains("1 vertices welded (kept-gone): 3-4") &&
                                Catch::Contains("1 triangles that repeat another one dropped (kept-gone): 3-4"));
    const gradus::Diagnosis good = gradus::diagnose(gradus::read_mesh(folder / "good.obj"));
    CHECK(gradus::is_clean_manifold(good));
    CHECK(good.components == 2);

    const json said = json::parse(run(folder, "info bad.obj --repair --json").out);
    CHECK(said["manifold"] == false);
    CHECK(said["repair"]["steps"].size() == 3);
    CHECK(said["repair"]["result"]["manifold"] == true);
    CHECK(said["repair"]["result"]["triangles"] == 5);
    CHECK(said["repair"]["result"]["self_contacts"]["count"].get<int>() >= 2);
    CHECK(said["repair"]["result"]["self_contacts"]["first"][0].size() == 2);

    const Outcome again = run(folder, "info good.obj --repair");
    CHECK_THAT(again.out, Catch::Contains("nothing to repair"));
    spill(folder / "points.obj", "v 0 0 0\nv 1 0 0\n");
    CHECK_THAT(run(folder, "info points.obj").out, Catch::Contains("NOT usable: holds no triangles"));
    check_failure(run(folder, "info bad.obj -o good.obj"), 2, "give --repair too");
    check_failure(run(folder, "info bad.obj --repair --weld 2"), 2, "--weld 2: must be from 0 to 0.1");
    check_failure(run(folder, "info bad.obj --repair -o nowhere/x.obj"), 1, "there is no folder nowhere");
    check_failure(run(folder, "info none.bpt --repair"), 2, "--repair is for triangle meshes");
}
