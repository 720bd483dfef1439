// The program on triangulations: chord errors that are kept and proved, size maps, repair, and refusals.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "gradus/quality/hausdorff.hpp"
#include "support/files.hpp"
#include "support/program.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using nlohmann::json;
using support::Outcome;
using support::run;
using support::TemporaryFolder;

namespace {

MeshView view(const TriangleSoup& soup) { return {soup.points, soup.triangles}; }

double bound_between(const TriangleSoup& a, const TriangleSoup& b) {
    const OneSidedOptions precise{.precision = 0.002};
    return std::max(DistanceTarget(view(a)).measure_from(view(b), precise).bound,
                    DistanceTarget(view(b)).measure_from(view(a), precise).bound);
}

// A cylinder with caps: flat, round and sharp.
TriangleSoup tin() { return triangulations::soup(triangulations::capped_cylinder(60, 12, 1, 2, 4)); }

TriangleSoup with_flipped(TriangleSoup soup, int triangle) {
    std::swap(soup.triangles[triangle][1], soup.triangles[triangle][2]);
    return soup;
}

}  // namespace

TEST_CASE("remesh keeps the chord error asked for between a triangulation and its mesh", "[cli]") {
    const TemporaryFolder folder;
    const std::string in = GENERATE("in.off", "in.stl");
    write_mesh(folder / in, tin());
    const double error = GENERATE(0.02, 0.005);
    CAPTURE(in, error);
    const Outcome outcome = run(folder, "remesh " + in + " -o out.off --json --chord-error " + std::to_string(error));
    CAPTURE(outcome.err, outcome.out);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["chord_error"] == error);
    CHECK(said["chord_error_kept"] == true);
    CHECK(said["distance"]["from_input"]["bound"].get<double>() <= error);
    CHECK(said["distance"]["from_mesh"]["bound"].get<double>() <= error);
    CHECK(said["feature_curves"] == 2);
    CHECK(said["corners"] == 0);
    const TriangleSoup mesh = read_mesh(folder / "out.off");
    CHECK(said["triangles"] == mesh.triangles.size());
    CHECK(is_clean_manifold(diagnose(mesh)));
    CHECK(diagnose(mesh).components == 1);
    CHECK(bound_between(read_mesh(folder / in), mesh) <= error * 1.002);
}

TEST_CASE("a chord error that the smallest size makes impossible is not kept, and said so", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const std::string arguments = "remesh in.off --chord-error 0.001 --hmin 0.5 --hmax 0.6";
    const Outcome text = run(folder, arguments + " -o out.off");
    CAPTURE(text.out, text.err);
    CHECK(text.code == 1);
    CHECK_THAT(text.out, Catch::Contains("NOT kept"));
    CHECK(bound_between(tin(), read_mesh(folder / "out.off")) > 0.001);
    const Outcome machine = run(folder, arguments + " -o again.off --json");
    CHECK(machine.code == 1);
    const json said = json::parse(machine.out);
    CHECK(said["chord_error_kept"] == false);
    CHECK(std::max(said["distance"]["from_input"]["bound"].get<double>(), said["distance"]["from_mesh"]["bound"].get<double>()) > 0.001);
    CHECK(read_file(folder / "again.off") == read_file(folder / "out.off"));
}

TEST_CASE("without a chord error the distance is told, not judged", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", triangulations::soup(triangulations::sphere(3)));
    const Outcome outcome = run(folder, "remesh in.off -o out.off --json");
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["chord_error"].is_null());
    CHECK(said["chord_error_kept"].is_null());
    CHECK(said["feature_curves"] == 0);
    const double told =
        std::max(said["distance"]["from_input"]["bound"].get<double>(), said["distance"]["from_mesh"]["bound"].get<double>());
    CHECK(told == Approx(bound_between(read_mesh(folder / "in.off"), read_mesh(folder / "out.off"))).epsilon(0.03));
}

TEST_CASE("a triangulation that is no oriented manifold is refused, or repaired where asked", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "bad.off", with_flipped(tin(), 40));
    const Outcome refused = run(folder, "remesh bad.off -o out.off");
    CHECK(refused.code == 1);
    CHECK_THAT(refused.err, Catch::StartsWith("gradus: error: bad.off: not an oriented manifold") && Catch::Contains("--repair"));
    CHECK_FALSE(std::filesystem::exists(folder / "out.off"));
    CHECK(run(folder, "sizemap bad.off -o out.sol").code == 1);

    const Outcome repaired = run(folder, "remesh bad.off -o out.off --repair --chord-error 0.02");
    CAPTURE(repaired.out, repaired.err);
    CHECK(repaired.code == 0);
    CHECK_THAT(repaired.out, Catch::Contains("bad.off repaired:") && Catch::Contains("turned round"));
    CHECK(is_clean_manifold(diagnose(read_mesh(folder / "out.off"))));
    CHECK(bound_between(tin(), read_mesh(folder / "out.off")) <= 0.02 * 1.002);
    write_mesh(folder / "good.off", tin());
    CHECK_THAT(run(folder, "remesh good.off -o out.off --repair").out, Catch::Contains("good.off: nothing to repair"));
}

TEST_CASE("sizes of a triangulation go from sizemap through grade to remesh", "[cli]") {
    const TemporaryFolder folder;
    const TriangleSoup in = tin();
    write_mesh(folder / "in.off", in);
    REQUIRE(run(folder, "sizemap in.off -o raw.sol --size-at 1,0,1=0.02").code == 0);
    const std::vector<double> raw = read_sizes(folder / "raw.sol", in.points.size());
    CHECK(*std::min_element(raw.begin(), raw.end()) == Approx(0.02));
    REQUIRE(run(folder, "grade in.off --size raw.sol --shock 1.4 -o graded.sol").code == 0);
    const std::vector<double> graded = read_sizes(folder / "graded.sol", in.points.size());
    for (std::size_t v = 0; v < raw.size(); ++v) CHECK(graded[v] <= raw[v] * (1 + 1e-9));
    const Outcome outcome = run(folder, "remesh in.off --size graded.sol --no-gradation -o out.off --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["sizing"].is_null());
    CHECK(said["gradation"].is_null());
    CHECK(said["background_vertices"] == in.points.size());
    CHECK(said["triangles"].get<double>() == Approx(said["predicted_triangles"].get<double>()).epsilon(0.15));
    CHECK(said["area_length"]["mean"].get<double>() > 0.9);
    CHECK(is_clean_manifold(diagnose(read_mesh(folder / "out.off"))));

    SECTION("a map for another mesh is refused") {
        write_sizes(folder / "short.sol", std::vector<double>(7, 0.1));
        const Outcome refused = run(folder, "remesh in.off --size short.sol -o other.off");
        CHECK(refused.code == 1);
        CHECK_THAT(refused.err, Catch::StartsWith("gradus: error: short.sol"));
        CHECK_FALSE(std::filesystem::exists(folder / "other.off"));
    }
    SECTION("a background of its own is refused") {
        const Outcome refused = run(folder, "remesh in.off --size graded.sol --background in.off -o other.off");
        CHECK(refused.code == 2);
        CHECK_THAT(refused.err, Catch::Contains("--background is for patches"));
        CHECK_FALSE(std::filesystem::exists(folder / "other.off"));
        CHECK(run(folder, "sizemap in.off --background bg.mesh -o other.sol").code == 2);
    }
    SECTION("a map of too many triangles is refused with the number") {
        const Outcome refused = run(folder, "remesh in.off --size graded.sol --max-triangles 1000 -o other.off");
        CHECK(refused.code == 1);
        CHECK_THAT(refused.err, Catch::StartsWith("gradus: error: "));
        CHECK_FALSE(std::filesystem::exists(folder / "other.off"));
    }
}

TEST_CASE("remesh of a triangulation is the same for any number of threads, and labels are kept", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = tin();
    for (const Triangle& t : in.triangles) in.labels.push_back((in.points[t[0]] + in.points[t[1]] + in.points[t[2]]).z() < 3 ? 3 : 8);
    write_mesh(folder / "in.mesh", in);
    REQUIRE(run(folder, "remesh in.mesh -o one.mesh --threads 1 --chord-error 0.01 -q").code == 0);
    REQUIRE(run(folder, "remesh in.mesh -o two.mesh --threads 2 --chord-error 0.01 -q").code == 0);
    CHECK(read_file(folder / "one.mesh") == read_file(folder / "two.mesh"));
    const TriangleSoup out = read_mesh(folder / "one.mesh");
    REQUIRE(out.labels.size() == out.triangles.size());
    for (std::size_t t = 0; t < out.triangles.size(); ++t) {
        const Triangle& v = out.triangles[t];
        CHECK(out.labels[t] == ((out.points[v[0]] + out.points[v[1]] + out.points[v[2]]).z() < 3 ? 3 : 8));
    }
    const auto curves = [&](const std::string& options) {
        return json::parse(run(folder, "remesh in.mesh -o out.mesh --json " + options).out)["feature_curves"].get<int>();
    };
    CHECK(curves("") == 3);
    CHECK(curves("--no-label-borders") == 2);
    CHECK(curves("--no-label-borders --feature-angle 170") == 0);
}

TEST_CASE("sizes follow clearances and labels where asked", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup plate = triangulations::soup(triangulations::cube(8));
    for (Eigen::Vector3d& p : plate.points) p.z() *= 0.05;
    for (const Triangle& t : plate.triangles)
        plate.labels.push_back(plate.points[t[0]].z() + plate.points[t[1]].z() + plate.points[t[2]].z() > 0.149 ? 5 : 2);
    write_mesh(folder / "in.mesh", plate);
    const std::string sizes = "--hmin 0.01 --hmax 0.2 -o map.sol --json";
    const auto map = [&](const std::string& options) {
        const Outcome outcome = run(folder, "sizemap in.mesh " + sizes + " " + options);
        CAPTURE(options, outcome.err);
        REQUIRE(outcome.code == 0);
        return read_sizes(folder / "map.sol", plate.points.size());
    };
    const auto smallest = [](const std::vector<double>& h) { return *std::min_element(h.begin(), h.end()); };
    CHECK(smallest(map("--feature-gap 0")) == Approx(0.2));
    CHECK(smallest(map("")) == Approx(0.075));
    CHECK(smallest(map("--feature-gap 2")) == Approx(0.1));
    CHECK(smallest(map("--feature-gap 0 --gap 3")) == Approx(0.15));
    const std::vector<double> region = map("--feature-gap 0 --size-region 5=0.02 --size-region 2=0.12");
    for (std::size_t v = 0; v < region.size(); ++v) CHECK(region[v] == Approx(plate.points[v].z() > 0.049 ? 0.02 : 0.12));

    const Outcome coarse = run(folder, "remesh in.mesh -o out.mesh --hmin 0.01 --hmax 0.2 --feature-gap 0 --json");
    const Outcome fine = run(folder, "remesh in.mesh -o out.mesh --hmin 0.01 --hmax 0.2 --gap 1 --json");
    REQUIRE((coarse.code == 0 && fine.code == 0));
    CHECK(json::parse(fine.out)["triangles"] > 2 * json::parse(coarse.out)["triangles"].get<int>());
    CHECK(json::parse(fine.out)["sizing"]["gap"] == 1);

    const Outcome unknown = run(folder, "remesh in.mesh -o out.mesh --size-region 7=0.1");
    CHECK(unknown.code == 1);
    CHECK_THAT(unknown.err, Catch::Contains("label 7") && Catch::Contains("2, 5"));
    for (const std::string wrong : {"--size-region 7", "--size-region 7=x", "--size-region 7=-1", "--gap -1", "--feature-gap nan", "--gap 1 --size map.sol"})
        CHECK(run(folder, "remesh in.mesh -o out.mesh " + wrong).code == 2);
    for (const std::string option : {"--gap 1", "--feature-gap 1", "--size-region 1=1"}) {
        const Outcome patches = run(folder, "remesh some.bpt -o out.mesh " + option);
        CHECK(patches.code == 2);
        CHECK_THAT(patches.err, Catch::Contains("is for triangulations"));
    }
}
