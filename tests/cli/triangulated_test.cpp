// The program on triangulations: chord errors that are kept and proved, size maps, repair, and refusals.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "gradus/quality/hausdorff.hpp"
#include "support/files.hpp"
#include "support/parts.hpp"
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

TEST_CASE("folds become features where the chord error cannot be kept otherwise", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", triangulations::soup(triangulations::cube(8)));
    const auto remesh = [&](const std::string& hmin) {
        const Outcome outcome =
            run(folder, "remesh in.off -o out.off --json --feature-angle 180 --chord-error 0.002 --hmin " + hmin +
                            " --hmax 0.3");
        REQUIRE(outcome.code == 0);
        return json::parse(outcome.out);
    };
    // With small elements it is kept across edges that are none, else it is not.
    CHECK(remesh("0.0004")["feature_curves"] == 0);
    const json said = remesh("0.05");
    CHECK(said["feature_curves"] == 12);
    CHECK(said["features_added"] == 96);
    CHECK(said["triangles"] < 400);
    CHECK(bound_between(read_mesh(folder / "in.off"), read_mesh(folder / "out.off")) <= 0.002 * 1.002);
    std::map<std::string, int> stages;
    for (const json& stage : said["stages"]) ++stages[stage["name"]];
    CHECK(stages.at("meshing") == 1);
    CHECK(stages.count("features") == 1);
}

TEST_CASE("a chord error below what distances are rounded to is refused", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", triangulations::soup(triangulations::cube(2)));
    const Outcome outcome = run(folder, "remesh in.off -o out.off --chord-error 1e-12");
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Catch::Contains("--chord-error 1e-12"));
}

TEST_CASE("a chord error that the smallest size makes impossible is not kept, and said so", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const std::string arguments = "remesh in.off --chord-error 0.001 --hmin 0.5 --hmax 0.6";
    const Outcome text = run(folder, arguments + " -o out.off");
    CAPTURE(text.out, text.err);
    CHECK(text.code == 1);
    CHECK_THAT(text.out, Catch::Contains("NOT kept"));
    CHECK_THAT(text.err, Catch::Contains("farther from it than the chord error"));
    CHECK(bound_between(tin(), read_mesh(folder / "out.off")) > 0.001);
    const Outcome machine = run(folder, arguments + " -o again.off --json");
    CHECK(machine.code == 1);
    const json said = json::parse(machine.out);
    CHECK(said["chord_error_kept"] == false);
    CHECK(std::max(said["distance"]["from_input"]["bound"].get<double>(),
                   said["distance"]["from_mesh"]["bound"].get<double>()) > 0.001);
    CHECK(read_file(folder / "again.off") == read_file(folder / "out.off"));
}

TEST_CASE("pictures of a triangulation show the input beside the mesh", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const Outcome outcome = run(folder, "remesh in.off -o out.off --chord-error 0.02 --pictures shown");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    for (const std::string name : {"input", "mesh", "size"}) {
        CAPTURE(name);
        CHECK(std::filesystem::file_size(folder / ("shown/" + name + ".png")) > 1000);
    }
    CHECK(read_file(folder / "shown/input.png") != read_file(folder / "shown/mesh.png"));
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
    const double told = std::max(said["distance"]["from_input"]["bound"].get<double>(),
                                 said["distance"]["from_mesh"]["bound"].get<double>());
    CHECK(told == Approx(bound_between(read_mesh(folder / "in.off"), read_mesh(folder / "out.off"))).epsilon(0.03));
}

TEST_CASE("a triangulation that is no oriented manifold is refused, or repaired where asked", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "bad.off", with_flipped(tin(), 40));
    const Outcome refused = run(folder, "remesh bad.off -o out.off");
    CHECK(refused.code == 1);
    CHECK_THAT(refused.err,
               Catch::StartsWith("gradus: error: bad.off: not an oriented manifold") && Catch::Contains("--repair"));
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
    SECTION("the triangulation itself may be named as the background") {
        REQUIRE(run(folder, "remesh in.off --size graded.sol --background in.off --no-gradation -o same.off").code ==
                0);
        CHECK(read_file(folder / "same.off") == read_file(folder / "out.off"));
    }
    SECTION("a map of too many triangles is refused with the number") {
        const Outcome refused = run(folder, "remesh in.off --size graded.sol --max-triangles 1000 -o other.off");
        CHECK(refused.code == 1);
        CHECK_THAT(refused.err, Catch::StartsWith("gradus: error: "));
        CHECK_FALSE(std::filesystem::exists(folder / "other.off"));
    }
}

TEST_CASE("sizemap of a triangulation writes a refined background where asked, which grade and remesh take", "[cli]") {
    const TemporaryFolder folder;
    // Facets of the caps are as long as the radius, the size at their rims is a tenth of it.
    const TriangleSoup in = triangulations::soup(triangulations::capped_cylinder(32, 8, 1, 2));
    write_mesh(folder / "in.off", in);
    const std::string sizing = " --alpha 0.1 --hmin 0.01 --hmax 0.6";
    const Outcome made = run(folder, "sizemap in.off -o raw.sol --background bg.mesh --json" + sizing);
    CAPTURE(made.err);
    REQUIRE(made.code == 0);
    const json map = json::parse(made.out);
    CHECK(map["files"] == json::array({"raw.sol", "bg.mesh"}));
    const TriangleSoup background = read_mesh(folder / "bg.mesh");
    REQUIRE(background.points.size() > in.points.size() + 32);
    CHECK(map["vertices"] == background.points.size());
    CHECK(std::equal(in.points.begin(), in.points.end(), background.points.begin()));
    CHECK(is_clean_manifold(diagnose(background)));
    CHECK(bound_between(in, background) < 1e-9);
    const std::vector<double> raw = read_sizes(folder / "raw.sol", background.points.size());
    CHECK(map["size_min"] == *std::min_element(raw.begin(), raw.end()));

    SECTION("the way by the files is that of remesh alone") {
        REQUIRE(run(folder, "grade bg.mesh --size raw.sol --shock 1.5 -o graded.sol").code == 0);
        const Outcome by_files =
            run(folder, "remesh in.off --size graded.sol --background bg.mesh --no-gradation -o out.off --json");
        CAPTURE(by_files.err);
        REQUIRE(by_files.code == 0);
        CHECK(json::parse(by_files.out)["background_vertices"] == background.points.size());
        REQUIRE(run(folder, "remesh in.off -o alone.off --shock 1.5" + sizing).code == 0);
        // Not to the last bit: alone it numbers the triangulation anew, and cuts equal edges of the background in
        // another order.
        const TriangleSoup out = read_mesh(folder / "out.off"), alone = read_mesh(folder / "alone.off");
        CHECK(double(out.triangles.size()) == Approx(double(alone.triangles.size())).epsilon(0.04));
        CHECK(bound_between(out, alone) < 0.02);
    }
    SECTION("sizes on the input's own vertices say less: the insides of the caps are as fine as their rims") {
        const Outcome coarse = run(folder, "sizemap in.off -o own.sol --json" + sizing);
        REQUIRE(coarse.code == 0);
        CHECK(read_sizes(folder / "own.sol", in.points.size()).size() == in.points.size());
        CHECK(json::parse(coarse.out)["predicted_triangles"].get<double>() >
              1.1 * map["predicted_triangles"].get<double>());
    }
    SECTION("maps in formats that hold the mesh are the same sizes on the same mesh, and say so alone") {
        REQUIRE(run(folder, "sizemap in.off -o own.sol -q" + sizing).code == 0);
        const std::vector<double> own = read_sizes(folder / "own.sol", in.points.size());
        for (const std::string extension : {"msh", "vtu", "ply"}) {
            CAPTURE(extension);
            const Outcome outcome = run(folder, "sizemap in.off --json -o own." + extension + sizing);
            REQUIRE(outcome.code == 0);
            CHECK(json::parse(outcome.out)["files"] == json{"own." + extension});
            REQUIRE(run(folder, "grade own.mesh --size own.sol --shock 100 -q -o graded." + extension).code == 0);
            for (const std::string& file : {"own." + extension, "graded." + extension}) {
                const MeshData read = read_mesh_data(folder / file);
                CHECK(read.soup.triangles == in.triangles);
                const auto size = std::find_if(read.point_fields.begin(), read.point_fields.end(),
                                               [](const Field& f) { return f.name == "size"; });
                REQUIRE(size != read.point_fields.end());
                REQUIRE(size->values.size() == own.size());
                if (file[0] == 'o') CHECK(size->values == own);
            }
            CHECK((read_file(folder / ("own." + extension)).find("uchar red") != std::string::npos) ==
                  (extension == "ply"));
        }
        CHECK(run(folder, "sizemap in.off -o own.stl" + sizing).code == 2);
    }
    SECTION("a background that exists is kept, and gets the sizes of its places") {
        const std::string before = read_file(folder / "bg.mesh");
        REQUIRE(run(folder, "sizemap in.off -o again.sol --background bg.mesh -q" + sizing).code == 0);
        CHECK(read_file(folder / "bg.mesh") == before);
        const std::vector<double> again = read_sizes(folder / "again.sol", background.points.size());
        for (std::size_t v = 0; v < raw.size(); ++v) CHECK(again[v] == Approx(raw[v]));
    }
    SECTION("other meshes of the surface carry sizes too, those of another one none") {
        write_mesh(folder / "other.off", triangulations::soup(triangulations::capped_cylinder(48, 16, 1, 2, 6)));
        REQUIRE(run(folder, "sizemap in.off -o other.sol --background other.off -q" + sizing).code == 0);
        const std::string meshed =
            "remesh in.off --size other.sol --background other.off -o out.off --shock 1.5 --json";
        const Outcome outcome = run(folder, meshed);
        CAPTURE(outcome.err);
        REQUIRE(outcome.code == 0);
        const json said = json::parse(outcome.out);
        CHECK(said["triangles"].get<double>() == Approx(said["predicted_triangles"].get<double>()).epsilon(0.35));
        CHECK(is_clean_manifold(diagnose(read_mesh(folder / "out.off"))));

        write_mesh(folder / "far.off", triangulations::soup(triangulations::sphere(3, 2)));
        const Outcome refused = run(folder, "sizemap in.off -o far.sol --background far.off" + sizing);
        CHECK(refused.code == 1);
        CHECK_THAT(refused.err, Catch::StartsWith("gradus: error: far.off: not a mesh of the same surface"));
        write_sizes(folder / "far.sol", std::vector<double>(read_mesh(folder / "far.off").points.size(), 0.2));
        const Outcome unmeshed = run(folder, "remesh in.off --size far.sol --background far.off -o far.mesh");
        CHECK(unmeshed.code == 1);
        CHECK_THAT(unmeshed.err, Catch::StartsWith("gradus: error: far.off: not a mesh of the same surface"));
        CHECK_FALSE(std::filesystem::exists(folder / "far.mesh"));
    }
    SECTION("sizes that are not of the background are refused, and one of too many triangles") {
        CHECK(run(folder, "remesh in.off --size raw.sol -o other.off").code == 1);
        CHECK(run(folder, "remesh in.off --size raw.sol --background in.off -o other.off").code == 1);
        const Outcome refused =
            run(folder, "sizemap in.off -o many.sol --background many.mesh --max-triangles 300" + sizing);
        CHECK(refused.code == 1);
        CHECK_FALSE(std::filesystem::exists(folder / "many.mesh"));
    }
}

TEST_CASE("remesh of a triangulation is the same for any number of threads, and labels are kept", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = tin();
    for (const Triangle& t : in.triangles)
        in.labels.push_back((in.points[t[0]] + in.points[t[1]] + in.points[t[2]]).z() < 3 ? 3 : 8);
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
        return json::parse(run(folder, "remesh in.mesh -o out.mesh --json " + options).out)["feature_curves"]
            .get<int>();
    };
    CHECK(curves("") == 3);
    CHECK(curves("--no-label-borders") == 2);
    CHECK(curves("--no-label-borders --feature-angle 170") == 0);
}

namespace {

// The tin with a linear field on points, a vector, and a material on triangles: 3 below z = 1, 8 above.
MeshData tin_with_fields() {
    MeshData data{tin()};
    Field height{"height"}, place{"place", 3}, material{"material", 1, {}, true};
    for (const Eigen::Vector3d& p : data.soup.points) {
        height.values.push_back(1 + 2 * p.z());
        place.values.insert(place.values.end(), p.begin(), p.end());
    }
    for (const Triangle& t : data.soup.triangles) {
        const double z = data.soup.points[t[0]].z() + data.soup.points[t[1]].z() + data.soup.points[t[2]].z();
        data.soup.labels.push_back(z < 3 ? 3 : 8);
        material.values.push_back(data.soup.labels.back() + 100);
    }
    data.point_fields = {height, place};
    data.cell_fields = {material};
    return data;
}

const Field& field_called(const std::vector<Field>& fields, const std::string& name) {
    for (const Field& field : fields)
        if (field.name == name) return field;
    throw std::invalid_argument("no field " + name);
}

void check_carried(const MeshData& out) {
    const Field &height = field_called(out.point_fields, "height"), &place = field_called(out.point_fields, "place");
    REQUIRE(height.values.size() == out.soup.points.size());
    CHECK(place.components == 3);
    for (std::size_t v = 0; v < out.soup.points.size(); ++v) {
        const Eigen::Vector3d at(place.values[3 * v], place.values[3 * v + 1], place.values[3 * v + 2]);
        // The tin is of 60 sides: the mesh is on a round one, over places of its facets a little aside.
        CHECK((at - out.soup.points[v]).norm() < 0.015);
        CHECK(height.values[v] == Approx(1 + 2 * at.z()).margin(1e-12));
    }
    const Field& material = field_called(out.cell_fields, "material");
    for (std::size_t t = 0; t < out.soup.triangles.size(); ++t) {
        const Triangle& v = out.soup.triangles[t];
        const double z = (out.soup.points[v[0]] + out.soup.points[v[1]] + out.soup.points[v[2]]).z() / 3;
        CHECK(material.values[t] == (z < 1 ? 103 : 108));
    }
}

}  // namespace

TEST_CASE("remesh carries fields to the formats that hold them, and names the outputs that do not", "[cli]") {
    const TemporaryFolder folder;
    const std::string in = GENERATE("in.vtu", "in.ply", "in.msh");
    CAPTURE(in);
    write_mesh_data(folder / in, tin_with_fields());
    const Outcome outcome =
        run(folder, "remesh " + in + " -o out.vtu -o out.ply -o out.msh -o out.mesh -o out.obj --hmax 0.2");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK_THAT(outcome.out,
               Catch::Contains(
                   "fields: height, place (3) on points; material on triangles, carried to out.vtu out.ply out.msh\n"));
    CHECK_THAT(outcome.out,
               Catch::Contains("fields: out.mesh out.obj cannot hold these 3 fields; .msh .ply .vtu can\n"));
    for (const char* out : {"out.vtu", "out.ply", "out.msh"}) {
        CAPTURE(out);
        const MeshData data = read_mesh_data(folder / out);
        check_carried(data);
        REQUIRE(data.soup.labels.size() == data.soup.triangles.size());
        CHECK(std::set<int>(data.soup.labels.begin(), data.soup.labels.end()) == std::set<int>{3, 8});
    }
    CHECK(read_mesh(folder / "out.mesh").triangles.size() == read_mesh(folder / "out.vtu").triangles.size());

    SECTION("once more, fields of the mesh's own are its own") {
        const Outcome again = run(folder, "remesh out.vtu -o again.vtu --hmax 0.3 --json");
        REQUIRE(again.code == 0);
        const json fields = json::parse(again.out)["fields"];
        CHECK(fields["points"] ==
              json::parse(R"([{"name": "height", "components": 1}, {"name": "place", "components": 3}])"));
        CHECK(fields["cells"] == json::parse(R"([{"name": "material", "components": 1}])"));
        CHECK(fields["carried_to"] == json::parse(R"(["again.vtu"])"));
        CHECK(fields["left_behind"] == json::parse(R"(["size", "shock", "quality"])"));
        const MeshData data = read_mesh_data(folder / "again.vtu");
        CHECK(data.point_fields.size() == 4);
        CHECK(data.soup.labels.size() == data.soup.triangles.size());
        check_carried(data);
    }
    SECTION("info names them") {
        CHECK_THAT(run(folder, "info out.ply").out, Catch::Contains("fields on points: height, place (3)\n"));
        CHECK(json::parse(run(folder, "info out.ply --json").out)["point_fields"][1]["components"] == 3);
    }
}

TEST_CASE("remesh carries solutions at the vertices, also through a repair", "[cli]") {
    const TemporaryFolder folder;
    // Every triangle with vertices of its own, and one that is a copy.
    const TriangleSoup whole = tin();
    TriangleSoup loose;
    std::string text = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n" +
                       std::to_string(3 * whole.triangles.size()) + "\n2 1 2\n";
    for (const Triangle& t : whole.triangles) {
        const int first = static_cast<int>(loose.points.size());
        loose.triangles.push_back({first, first + 1, first + 2});
        for (const int v : t) {
            const Eigen::Vector3d& p = whole.points[v];
            loose.points.push_back(p);
            text += std::to_string(4 - p.z()) + " " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
                    std::to_string(p.z()) + "\n";
        }
    }
    loose.triangles.insert(loose.triangles.begin(), loose.triangles[5]);
    write_mesh(folder / "in.off", loose);
    support::spill(folder / "wind.sol", text + "End\n");
    const Outcome outcome = run(folder, "remesh in.off --repair --field wind.sol -o out.ply --hmax 0.2");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    const MeshData out = read_mesh_data(folder / "out.ply");
    REQUIRE(out.point_fields.size() == 2);
    CHECK(out.point_fields[0].name == "wind_1");
    CHECK(out.point_fields[1].components == 3);
    for (std::size_t v = 0; v < out.soup.points.size(); ++v) {
        CHECK(out.point_fields[0].values[v] == Approx(4 - out.soup.points[v].z()).margin(0.01));
        CHECK((Eigen::Vector3d(out.point_fields[1].values[3 * v], out.point_fields[1].values[3 * v + 1],
                               out.point_fields[1].values[3 * v + 2]) -
               out.soup.points[v])
                  .norm() < 0.01);
    }

    SECTION("info names the fields of a solution") {
        CHECK_THAT(run(folder, "info wind.sol").out, Catch::Contains("wind_1, wind_2 (3)"));
    }
    SECTION("info --repair keeps fields with their points") {
        MeshData data{loose, {{"z"}}};
        for (const Eigen::Vector3d& p : loose.points) data.point_fields[0].values.push_back(p.z());
        write_mesh_data(folder / "loose.vtu", data);
        REQUIRE(run(folder, "info loose.vtu --repair -o whole.msh").code == 0);
        const MeshData repaired = read_mesh_data(folder / "whole.msh");
        CHECK(repaired.soup.points.size() == whole.points.size());
        for (std::size_t v = 0; v < repaired.soup.points.size(); ++v)
            CHECK(repaired.point_fields[0].values[v] == repaired.soup.points[v].z());
        CHECK_THAT(run(folder, "info loose.vtu --repair -o whole.obj").out, Catch::Contains("without the fields"));
    }
    SECTION("a solution for another mesh, of another kind or of a taken name is refused") {
        write_mesh(folder / "tin.off", whole);
        const auto refused = [&](const std::string& arguments, int code, const std::string& part) {
            const Outcome failed = run(folder, "remesh " + arguments + " -o x.vtu");
            CAPTURE(arguments);
            CHECK(failed.code == code);
            CHECK_THAT(failed.err, Catch::Contains(part));
            CHECK_FALSE(std::filesystem::exists(folder / "x.vtu"));
        };
        refused("tin.off --field wind.sol", 1, "wind.sol:4: holds values at");
        refused("tin.off --field wind.txt", 2, "unknown extension \".txt\"");
        refused("'" GRADUS_ASSETS "/teapot.bpt' --field wind.sol", 2, "--field is for triangle meshes");
        write_sizes(folder / "size.sol", std::vector<double>(whole.points.size(), 1));
        refused("tin.off --field size.sol", 1, "the mesh has a field size already");
    }
}

TEST_CASE("report measures a mesh against a triangulated reference", "[cli]") {
    const TemporaryFolder folder;
    const testing::Mesh sphere = triangulations::sphere(4, 1, 0);
    write_mesh(folder / "scan.stl", triangulations::soup(sphere));
    write_mesh(folder / "same.obj", triangulations::soup(testing::relabelled(sphere, 3)));
    write_mesh(folder / "larger.off", triangulations::soup(triangulations::sphere(4, 1.1, 0)));
    const Outcome outcome = run(folder, "report larger.off --reference scan.stl -o r.html --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    const json hausdorff = said["reference"]["hausdorff"];
    CHECK(hausdorff["largest"].get<double>() == Approx(0.1).epsilon(0.01));
    CHECK(hausdorff["bound"].get<double>() <= 0.10102);
    CHECK(hausdorff["relative_bound"].get<double>() == Approx(0.1 / hausdorff["diagonal"].get<double>()).epsilon(0.02));
    CHECK(Eigen::Vector3d(hausdorff["at"][0], hausdorff["at"][1], hausdorff["at"][2]).norm() > 0.98);
    CHECK(said["distance"]["vertices"]["max"].get<double>() * hausdorff["diagonal"].get<double>() ==
          Approx(0.1).epsilon(0.01));
    CHECK(said["normals"]["angle"]["max"].get<double>() < 1);
    CHECK(said["reference"]["compared"].size() == 4);
    for (const json& compared : said["reference"]["compared"]) CHECK(compared["same"] == true);
    const std::string page = read_file(folder / "r.html");
    for (const char* part :
         {"Hausdorff distance", "genus of the reference: same", "angle to the surface", "from reference to mesh"})
        CHECK_THAT(page, Catch::Contains(part));

    const Outcome same = run(folder, "report same.obj --reference scan.stl");
    CHECK(same.code == 0);
    CHECK_THAT(same.out, Catch::Contains("Hausdorff distance to the reference") && Catch::Contains("same") &&
                             !Catch::Contains("differs"));
    CHECK(
        json::parse(run(folder, "report same.obj --reference scan.stl --json").out)["reference"]["hausdorff"]["largest"]
            .get<double>() < 1e-6);
    write_mesh(folder / "torus.off", triangulations::soup(triangulations::torus(20, 10)));
    CHECK_THAT(run(folder, "report torus.off --reference scan.stl").out, Catch::Contains("differs"));

    support::spill(folder / "none.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n");
    const Outcome empty = run(folder, "report same.obj --reference none.off");
    CHECK(empty.code == 1);
    CHECK_THAT(empty.err, Catch::Contains("none.off: holds no triangles"));
    CHECK(run(folder, "report same.obj --reference what.xyz").code == 2);
}

TEST_CASE("sizes follow clearances and labels where asked", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup plate = triangulations::soup(triangulations::cube(8));
    for (Eigen::Vector3d& p : plate.points) p.z() *= 0.05;
    for (const Triangle& t : plate.triangles)
        plate.labels.push_back(plate.points[t[0]].z() + plate.points[t[1]].z() + plate.points[t[2]].z() > 0.149 ? 5
                                                                                                                : 2);
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
    for (std::size_t v = 0; v < region.size(); ++v)
        CHECK(region[v] == Approx(plate.points[v].z() > 0.049 ? 0.02 : 0.12));

    const Outcome coarse = run(folder, "remesh in.mesh -o out.mesh --hmin 0.01 --hmax 0.2 --feature-gap 0 --json");
    const Outcome fine = run(folder, "remesh in.mesh -o out.mesh --hmin 0.01 --hmax 0.2 --gap 1 --json");
    REQUIRE((coarse.code == 0 && fine.code == 0));
    CHECK(json::parse(fine.out)["triangles"] > 2 * json::parse(coarse.out)["triangles"].get<int>());
    CHECK(json::parse(fine.out)["sizing"]["gap"] == 1);

    const Outcome unknown = run(folder, "remesh in.mesh -o out.mesh --size-region 7=0.1");
    CHECK(unknown.code == 1);
    CHECK_THAT(unknown.err, Catch::Contains("label 7") && Catch::Contains("2, 5"));
    for (const std::string wrong : {"--size-region 7", "--size-region 7=x", "--size-region 7=-1", "--gap -1",
                                    "--feature-gap nan", "--gap 1 --size map.sol"})
        CHECK(run(folder, "remesh in.mesh -o out.mesh " + wrong).code == 2);
    for (const std::string option : {"--gap 1", "--feature-gap 1", "--size-region 1=1"}) {
        const Outcome patches = run(folder, "remesh some.bpt -o out.mesh " + option);
        CHECK(patches.code == 2);
        CHECK_THAT(patches.err, Catch::Contains("is for triangulations"));
    }
}

TEST_CASE("sizemap leaves the mesh alone that it reads beside its sizes", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = tin();
    in.labels.assign(in.triangles.size(), 7);
    write_mesh(folder / "part.mesh", in);
    const std::string before = read_file(folder / "part.mesh");
    REQUIRE(run(folder, "sizemap part.mesh -o part.sol").code == 0);
    CHECK(read_file(folder / "part.mesh") == before);
    CHECK(read_sizes(folder / "part.sol").size() == in.points.size());
    CHECK(run(folder, "sizemap part.mesh -o part.sol --repair").code == 2);
    CHECK(read_file(folder / "part.mesh") == before);
}

TEST_CASE("where one output cannot hold a mesh none is written", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup large = tin();
    for (Eigen::Vector3d& p : large.points) p *= 1e39;
    write_mesh(folder / "large.off", large);
    std::ofstream(folder / "kept.obj") << "KEEP";
    const Outcome outcome = run(folder, "remesh large.off -o kept.obj -o out.stl");
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Catch::Contains("out.stl: vertex"));
    CHECK(read_file(folder / "kept.obj") == "KEEP");
    CHECK_FALSE(std::filesystem::exists(folder / "out.stl"));
}

TEST_CASE("numbers that are none, empty arguments and sizes beyond counting are refused in a line", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const auto [arguments, part] = GENERATE(table<std::string, std::string>({
        {"remesh in.off -o x.off --feature-angle nan", "--feature-angle nan"},
        {"remesh in.off -o x.off --alpha \"\"", "an argument is empty, after --alpha"},
        {"remesh in.off -o x.off --hmin 1e-30 --hmax 1e-9", "e+"},
    }));
    CAPTURE(arguments);
    const Outcome outcome = run(folder, arguments);
    CHECK(outcome.code != 0);
    CHECK_THAT(outcome.err, Catch::StartsWith("gradus: error: ") && Catch::Contains(part));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    CHECK_FALSE(std::filesystem::exists(folder / "x.off"));
}

TEST_CASE("report refuses coordinates whose distances are no numbers", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup large = tin();
    for (Eigen::Vector3d& p : large.points) p *= 1e200;
    write_mesh(folder / "large.off", large);
    const Outcome outcome = run(folder, "report large.off --reference large.off");
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Catch::Contains("1e100"));
}

TEST_CASE("remesh says where a size holds that is prescribed off the vertices", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const Outcome at_vertex = run(folder, "remesh in.off -o out.off --fast --size-at 1,0,1=0.1"),
                  far = run(folder, "remesh in.off -o out.off --fast --size-at 100,0,1=0.1");
    REQUIRE(at_vertex.code == 0);
    REQUIRE(far.code == 0);
    CHECK_THAT(at_vertex.out, !Catch::Contains("holds"));
    CHECK_THAT(far.out, Catch::Contains("the size 0.1 at 100 0 1 holds 99 from there"));
}

TEST_CASE("a size inside a large facet is met there, and grows from there no faster than asked for", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", triangulations::soup(triangulations::cube(2)));
    const double h = GENERATE(0.02, 1e-5);
    const std::string more = GENERATE("", " --chord-error 0.01");
    CAPTURE(h, more);
    const Outcome outcome = run(
        folder, "remesh in.off -o out.vtu --hmax 0.3 --growth 1.2 --size-at 0.43,0.37,1=" + std::to_string(h) + more);
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    const Eigen::Vector3d at(0.43, 0.37, 1);
    const TriangleSoup mesh = read_mesh(folder / "out.vtu");
    double longest = 0, nearest = 1;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d &p = mesh.points[t[k]], &q = mesh.points[t[(k + 1) % 3]];
            const double away = ((p + q) / 2 - at).norm(), length = (p - q).norm();
            nearest = std::min(nearest, (p - at).norm());
            if (away < 2 * h) longest = std::max(longest, length);
            // Unit edges of sizes that grow by ln 1.2 per length, from the vertex of the background that is within h.
            // On its face the way is straight.
            if (p.z() == 1 && q.z() == 1) CHECK(length < 1.6 * (h + std::log(1.2) * (away + h)));
        }
    CHECK(nearest < h);
    CHECK(longest > 0.6 * h);
    CHECK(longest < 2.5 * h);
}

TEST_CASE("sizes at points from which distances are no numbers are refused", "[cli][regression]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const Outcome outcome = run(folder, "remesh in.off -o out.off --size-at 1e308,1e308,-1e308=0.1");
    CHECK(outcome.code != 0);
    CHECK_THAT(outcome.err, Catch::Contains("a coordinate of a prescribed size"));
    CHECK_FALSE(std::filesystem::exists(folder / "out.off"));
}

TEST_CASE("edges are split on until those of two large facets have a size far below them", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", TriangleSoup{{{0, 0, 0}, {10, 0, 0}, {0, 1, 0}, {10, 1, 0}}, {{0, 1, 3}, {0, 3, 2}}});
    const Outcome outcome =
        run(folder, "remesh in.off -o out.off --hmax 1.5 --growth 1.5 --size-at 3.3,0.4,0=1e-5 --report out.json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json report = json::parse(read_file(folder / "out.json"));
    CHECK(report["edges"]["length"]["max"].get<double>() < 2);
    CHECK(report["shape"]["area_length"]["min"].get<double>() > 0.6);
}

TEST_CASE("a prism of six sides has edges, one of eight is a cylinder unless an angle says otherwise", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "six.off", triangulations::soup(triangulations::capped_cylinder(6, 1, 1, 2, 1)));
    write_mesh(folder / "eight.off", triangulations::soup(triangulations::capped_cylinder(8, 1, 1, 2, 1)));
    const auto curves = [&](const std::string& arguments) {
        const Outcome outcome = run(folder, "remesh " + arguments + " -o out.off --hmax 0.4 --json");
        CAPTURE(outcome.err);
        REQUIRE(outcome.code == 0);
        return json::parse(outcome.out)["feature_curves"].get<int>();
    };
    CHECK(curves("six.off") >= 6 + 2 * 6);
    CHECK(curves("eight.off --feature-angle 30") >= 8 + 2 * 8);
    CHECK(curves("eight.off") <= 2 * 8);
    CHECK(curves("six.off --feature-angle 70") <= 2 * 6);
}

// Their long sides have a hundred elements each, their short ones a thirtieth of one.
TEST_CASE("a long cylinder of needles gets the triangles that its sizes ask for", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", triangulations::soup(triangulations::capped_cylinder(600, 1, 1, 30, 1)));
    const Outcome outcome = run(folder, "remesh in.off -o out.off --chord-error 0.02 --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json report = json::parse(outcome.out);
    CHECK(report["triangles"].get<double>() < 1.2 * report["predicted_triangles"].get<double>());
    CHECK(report["area_length"]["min"].get<double>() > 0.6);
}

// A gear of 12 teeth; each flank is about as long as elements are.
TEST_CASE("sizes are lowered around elements that fall short without a cause, and only there", "[cli]") {
    const TemporaryFolder folder;
    const int teeth = 12, n = 4 * teeth;
    TriangleSoup gear;
    for (const double z : {0.0, 0.3})
        for (int i = 0; i < n; ++i) {
            constexpr std::array<double, 4> at{0.3, 0.4, 0.7, 0.8}, radius{1, 1.15, 1.15, 1};
            const double a = 2 * std::numbers::pi * (i / 4 + at[i % 4]) / teeth, r = radius[i % 4];
            gear.points.push_back({r * std::cos(a), r * std::sin(a), z});
        }
    gear.points.insert(gear.points.end(), {{0, 0, 0}, {0, 0, 0.3}});
    for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        gear.triangles.insert(gear.triangles.end(),
                              {{i, j, n + j}, {i, n + j, n + i}, {j, i, 2 * n}, {n + i, n + j, 2 * n + 1}});
    }
    write_mesh(folder / "gear.off", gear);
    const Outcome outcome = run(folder, "remesh gear.off -o out.off --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["refinements"] > 0);
    for (const auto& [name, unexplained] : said["offenders"]["unexplained"].items()) CHECK(unexplained["count"] == 0);

    write_mesh(folder / "cube.off", triangulations::soup(triangulations::cube(3)));
    const Outcome cube = run(folder, "remesh cube.off -o out.off --json");
    REQUIRE(cube.code == 0);
    CHECK(json::parse(cube.out)["refinements"] == 0);
}

TEST_CASE("a cone comes to a point without a bulge, its elements grow from there", "[cli]") {
    const TemporaryFolder folder;
    constexpr int n = 24;
    constexpr double height = 5;
    TriangleSoup cone;
    for (int i = 0; i < n; ++i) {
        const double a = 2 * std::numbers::pi * i / n;
        cone.points.push_back({std::cos(a), std::sin(a), 0});
        cone.triangles.insert(cone.triangles.end(), {{i, (i + 1) % n, n}, {(i + 1) % n, i, n + 1}});
    }
    cone.points.insert(cone.points.end(), {{0, 0, height}, {0, 0, 0}});
    write_mesh(folder / "cone.off", cone);
    const Outcome outcome = run(folder, "remesh cone.off -o out.off --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const TriangleSoup mesh = read_mesh(folder / "out.off");
    // The facets are up to .0086 inside.
    for (const Eigen::Vector3d& p : mesh.points) {
        const double beyond = std::hypot(p.x(), p.y()) - (1 - p.z() / height);
        CHECK(beyond < 0.02);
        if (p.z() > 0) CHECK(beyond > -0.01);
    }
    // The integral of 2 / (sqrt 3 h^2 / 2) over the mantle with h = .3 r comes to some 1 500 up to where h is hmin, and
    // the base to 80.
    CHECK(mesh.triangles.size() < 2500);
    CHECK(mesh.triangles.size() > 1000);
}

TEST_CASE("a plate thinner than the chord error keeps its creases", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup plate = triangulations::soup(triangulations::cube(1));
    for (Eigen::Vector3d& p : plate.points) p.z() *= 0.003;
    write_mesh(folder / "plate.off", plate);
    const Outcome outcome =
        run(folder, "remesh plate.off -o out.off --chord-error " + std::string(GENERATE("0.002", "0.02")) + " --json");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const json said = json::parse(outcome.out);
    CHECK(said["feature_curves"] == 12);
    CHECK(said["corners"] == 8);
    CHECK(said["area_length"]["min"].get<double>() > 0.6);
}

TEST_CASE("sizes that coordinates cannot show are refused", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", tin());
    const std::string h = GENERATE("1e-12", "1e-300");
    const Outcome outcome = run(folder, "remesh in.off -o out.off --size-at 1,0,1=" + h);
    CHECK(outcome.code != 0);
    CHECK_THAT(outcome.err, Catch::Contains("rounding leaves no triangles that small"));
    CHECK_FALSE(std::filesystem::exists(folder / "out.off"));
}

TEST_CASE("the flat faces of a rounded box stay flat and its volume what it is", "[cli]") {
    const TemporaryFolder folder;
    const double radius = GENERATE(0.1, 5.0);
    const TriangleSoup in = parts::prism(parts::rounded(100, 80, radius, 3), 60);
    const double diagonal = std::hypot(100, 80, 60);
    write_mesh(folder / "in.off", in);
    for (const std::string& options : {std::string(), " --chord-error " + std::to_string(0.001 * diagonal)}) {
        CAPTURE(radius, options);
        const Outcome outcome = run(folder, "remesh in.off -o out.off --json" + options);
        REQUIRE(outcome.code == 0);
        const json said = json::parse(outcome.out);
        // With a chord error the round of 0.1 is thinner than that: its middle is a ridge.
        CHECK(said["feature_curves"] == (radius < 1 && !options.empty() ? 12 : 2));
        CHECK(said["area_length"]["min"] > 0.7);
        CHECK(said["area_length"]["mean"] > 0.95);
        const TriangleSoup out = read_mesh(folder / "out.off");
        CHECK(parts::volume(out) == Approx(parts::volume(in)).epsilon(0.005));
        // A point off the box is over a round, in a corner.
        for (const Eigen::Vector3d& p : out.points) {
            const bool in_corner = std::min(p.x(), 100 - p.x()) < radius && std::min(p.y(), 80 - p.y()) < radius;
            CHECK((in_corner || (p.x() > -1e-9 && p.x() < 100 + 1e-9 && p.y() > -1e-9 && p.y() < 80 + 1e-9)));
            CHECK((p.z() > -1e-9 && p.z() < 60 + 1e-9));
        }
    }
}

TEST_CASE("where the chord error is far below the facets of a prism their bends are ridges", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", parts::prism(parts::polygon(8), 2));
    for (const std::string error : {"0.0035", "0.00035"}) {
        const Outcome outcome = run(folder, "remesh in.off -o out.off --json --chord-error " + error);
        REQUIRE(outcome.code == 0);
        CHECK(json::parse(outcome.out)["feature_curves"] == 24);
        CHECK(json::parse(outcome.out)["triangles"] < 1500);
    }
    write_mesh(folder / "many.off", parts::prism(parts::polygon(24), 2));
    const json many =
        json::parse(run(folder, "remesh many.off -o out.off --json --feature-angle 5 --chord-error 0.003").out);
    CHECK(many["feature_curves"] == 72);
}

TEST_CASE("spheres that larger elements would cut into each other are kept apart, or it is said", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = triangulations::soup(triangulations::sphere(4, 1));
    const TriangleSoup outer = triangulations::soup(triangulations::sphere(4, 1.02));
    const int n = static_cast<int>(in.points.size());
    for (const Eigen::Vector3d& p : outer.points) in.points.push_back(p);
    for (Triangle& t : in.triangles) std::swap(t[1], t[2]);
    for (const Triangle& t : outer.triangles) in.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    write_mesh(folder / "in.off", in);
    const Outcome held = run(folder, "remesh in.off -o out.off --hmin 0.4 --hmax 0.4 --json");
    CHECK(held.code == 1);
    CHECK_THAT(held.err, Catch::Contains("pairs of its triangles touch or intersect"));
    CHECK(json::parse(held.out)["new_contacts"]["count"] > 0);
    const Outcome free = run(folder, "remesh in.off -o out.off --hmin 0.01 --hmax 0.4 --json");
    CHECK(free.code == 0);
    CHECK(json::parse(free.out)["new_contacts"]["count"] == 0);
    CHECK(json::parse(run(folder, "info out.off --json").out)["self_contacts"]["count"] == 0);
}

TEST_CASE("limits of sizes go by connected part", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = parts::prism({{0, 0}, {1000, 0}, {1000, 1000}, {0, 1000}}, 1000);
    const TriangleSoup small = triangulations::soup(triangulations::sphere(3, 1));
    for (const Triangle& t : small.triangles) in.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    for (const Eigen::Vector3d& p : small.points) in.points.push_back(p + Eigen::Vector3d(-10, 0, 0));
    write_mesh(folder / "in.off", in);
    REQUIRE(run(folder, "remesh in.off -o out.off -q").code == 0);
    const TriangleSoup out = read_mesh(folder / "out.off");
    const auto of_sphere = std::count_if(out.triangles.begin(), out.triangles.end(),
                                         [&](const Triangle& t) { return out.points[t[0]].x() < -5; });
    CHECK(of_sphere > 300);
}

TEST_CASE("vertices of an STL a rounding apart are one, others at open edges with --repair", "[cli]") {
    const TemporaryFolder folder;
    const triangulations::Mesh sphere = triangulations::sphere(3, 10);
    const double off = GENERATE(2e-15, 1e-5);
    CAPTURE(off);
    std::ofstream stl(folder / "in.stl");
    stl.precision(17);
    stl << "solid s\n";
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
        stl << "facet normal 0 0 0\nouter loop\n";
        for (const int v : sphere.triangles[i]) {
            const Eigen::Vector3d p =
                sphere.points[v] +
                off * Eigen::Vector3d(std::sin(7. * double(i)), std::cos(5. * double(i)), std::sin(3. * double(i)));
            stl << "vertex " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
        }
        stl << "endloop\nendfacet\n";
    }
    stl << "endsolid s\n";
    stl.close();
    const Outcome outcome = run(folder, std::string("remesh in.stl -o out.off") + (off > 1e-10 ? " --repair" : ""));
    REQUIRE(outcome.code == 0);
    CHECK_THAT(outcome.out, Catch::Contains(off > 1e-10 ? "at open edges within" : "a rounding from others"));
    const Diagnosis diagnosis = diagnose(read_mesh(folder / "out.off"));
    CHECK(diagnosis.closed);
    CHECK(diagnosis.components == 1);
}

TEST_CASE("a round that hmin is too large for is passed over, and that is said with the place", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", parts::prism(parts::rounded(1, 1, 0.01, 2), 1));
    const double error = 0.00173;
    const Outcome outcome =
        run(folder, "remesh in.off -o out.off --hmin 0.05 --json --chord-error " + std::to_string(error));
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err,
               Catch::Contains("where --hmin 0.05 allows no smaller elements") && Catch::Contains("by 0.00"));
    const json said = json::parse(outcome.out);
    CHECK(said["distance"]["from_input"]["bound"] < 2.4 * error);
    CHECK(said["distance"]["from_mesh"]["bound"] < 2.4 * error);
    CHECK(said["area_length"]["min"] > 0.7);
}

TEST_CASE("parts below the smallest size are named", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = parts::prism(parts::polygon(4), 1);
    for (const Eigen::Vector3d& shift : {Eigen::Vector3d(3, 0, 0), Eigen::Vector3d(5, 0, 0)}) {
        const int n = static_cast<int>(in.points.size());
        const TriangleSoup small = triangulations::soup(triangulations::sphere(2, 0.1));
        for (const Eigen::Vector3d& p : small.points) in.points.push_back(p + shift);
        for (const Triangle& t : small.triangles) in.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    }
    write_mesh(folder / "in.off", in);
    const Outcome outcome = run(folder, "remesh in.off -o out.off --hmin 0.5 --hmax 0.5");
    const auto first = outcome.err.find("is smaller than --hmin 0.5");
    REQUIRE(first != std::string::npos);
    CHECK(outcome.err.find("is smaller than --hmin 0.5", first + 1) != std::string::npos);
    CHECK_THAT(run(folder, "remesh in.off -o out.off --hmin 0.05").err, !Catch::Contains("smaller than --hmin"));
}

TEST_CASE("info ends in a verdict with the cure, and remesh points to it", "[cli]") {
    const TemporaryFolder folder;
    const TriangleSoup whole = parts::prism(parts::polygon(12), 1);
    TriangleSoup apart;
    for (const Triangle& t : whole.triangles) {
        const int n = static_cast<int>(apart.points.size());
        for (const int v : t) apart.points.push_back(whole.points[v]);
        apart.triangles.push_back({n, n + 1, n + 2});
    }
    write_mesh(folder / "whole.off", whole);
    write_mesh(folder / "apart.off", apart);
    CHECK_THAT(run(folder, "info whole.off").out, Catch::EndsWith("nothing wrong found\n"));
    const std::string cracks = std::to_string(apart.points.size() - whole.points.size()) + " vertices";
    CHECK_THAT(run(folder, "info apart.off").out,
               Catch::Contains("usable, but not sound: " + cracks + " at open edges lie on others") &&
                   Catch::Contains("--repair would do this:\n  " + cracks + " welded"));
    CHECK_THAT(run(folder, "remesh apart.off -o out.off --hmin 1 --hmax 1").err,
               Catch::Contains(cracks + " at open edges lie on others (cracks), which --repair closes"));
    CHECK(run(folder, "remesh apart.off -o out.off --repair").err.empty());
    CHECK(diagnose(read_mesh(folder / "out.off")).closed);
}

TEST_CASE("a mesh that single precision cannot hold is not written as STL", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup in = parts::prism(parts::polygon(12), 1);
    for (Eigen::Vector3d& p : in.points) p += Eigen::Vector3d(441871, 6329700, 100);
    write_mesh(folder / "in.off", in);
    const Outcome outcome = run(folder, "remesh in.off -o out.stl");
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Catch::Contains("out.stl: binary STL has single precision") &&
                                Catch::Contains("move the surface to the origin"));
    CHECK_FALSE(std::filesystem::exists(folder / "out.stl"));
    CHECK(run(folder, "remesh in.off -o out.off").code == 0);
}

TEST_CASE("the cylinders of a shaft stay straight up to their fillets", "[cli]") {
    const TemporaryFolder folder;
    // Radius 10 up to a fillet of radius 1, a shoulder to radius 16.
    parts::Outline profile{{10, 0}, {10, 40}};
    for (int k = 1; k <= 4; ++k) {
        const double angle = k * std::numbers::pi / 8;
        profile.emplace_back(11 - std::cos(angle), 40 + std::sin(angle));
    }
    profile.insert(profile.end(), {{16, 41}, {16, 60}});
    write_mesh(folder / "in.off", parts::revolved(profile, 48));
    REQUIRE(run(folder, "remesh in.off -o out.off -q").code == 0);
    int on_cylinder = 0;
    for (const Eigen::Vector3d& p : read_mesh(folder / "out.off").points) {
        if (!(p.z() > 1e-9 && p.z() < 40) || p.head<2>().norm() > 12 || p.head<2>().norm() < 9) continue;
        ++on_cylinder;
        CHECK(p.head<2>().norm() == Approx(10).epsilon(0.002));
    }
    CHECK(on_cylinder > 100);
}

TEST_CASE("the edges of a narrow wedge are creases, though its corners leave little room", "[cli]") {
    const TemporaryFolder folder;
    const double angle = GENERATE(2.0, 10.0, 25.0);
    CAPTURE(angle);
    const TriangleSoup in = parts::prism({{0, 0}, {1, 0}, {1, std::tan(angle * std::numbers::pi / 180)}}, 0.5);
    write_mesh(folder / "in.off", in);
    const json said = json::parse(run(folder, "remesh in.off -o out.off --json").out);
    CHECK(said["feature_curves"] == 9);
    CHECK(said["corners"] == 6);
    CHECK(parts::volume(read_mesh(folder / "out.off")) == Approx(parts::volume(in)).epsilon(1e-9));
}

TEST_CASE("a helical gear keeps its edges, and its caps their plane", "[cli]") {
    const TemporaryFolder folder;
    const TriangleSoup in = parts::twisted(parts::gear(12, 3, 0.7), 0.6, 0.5, 8);
    write_mesh(folder / "in.off", in);
    const std::string limit = GENERATE("", " --chord-error 0.002");
    const Outcome ran = run(folder, "remesh in.off -o out.off --json" + limit);
    REQUIRE(ran.code == 0);  // no contacts, and the chord error kept
    const json said = json::parse(ran.out);
    CHECK(said["feature_curves"] ==
          12 * 12);  // of each tooth: on both caps its tip, its root and its flanks, and four edges between
    CHECK(said["corners"] == 12 * 8);
    const TriangleSoup out = read_mesh(folder / "out.off");
    CHECK(said["area_length"]["min"] > 0.6);
    for (const Eigen::Vector3d& p : out.points) CHECK((p.z() > -1e-12 && p.z() < 0.6 + 1e-12));
}

TEST_CASE("a shaft that is long for its chord error stays one", "[cli]") {
    const TemporaryFolder folder;
    const parts::Outline profile{{1, 0}, {1, 200}, {1.2, 200.2}, {1.2, 210}, {0.8, 210.4}, {0.8, 500}};
    write_mesh(folder / "in.off", parts::revolved(profile, 24));
    const Outcome ran = run(folder, "remesh in.off -o out.off --chord-error 0.5 --json");
    REQUIRE(ran.code == 0);
    const json said = json::parse(ran.out);
    CHECK(said["chord_error_kept"] == true);
    CHECK(said["new_contacts"]["count"] == 0);
    CHECK(said["area_length"]["min"] > 0.7);
}

TEST_CASE("a box whose rounds are below the chord error has the edges and corners of a box", "[cli]") {
    const TemporaryFolder folder;
    const int facets = GENERATE(1, 2, 3, 8);
    CAPTURE(facets);
    write_mesh(folder / "in.off", parts::rounded_box({10, 6, 4}, 0.05, facets));
    const Outcome ran = run(folder, "remesh in.off -o out.off --chord-error 0.1 --json");
    REQUIRE(ran.code == 0);
    const json said = json::parse(ran.out);
    CHECK(said["feature_curves"] == 12);
    CHECK(said["corners"] == 8);
    CHECK(said["triangles"] < 2000);
    CHECK(said["area_length"]["min"] > 0.7);
}

TEST_CASE("labels that a format cannot hold are said to be left behind", "[cli]") {
    const TemporaryFolder folder;
    TriangleSoup cube = triangulations::soup(triangulations::cube(1));
    cube.labels.assign(cube.triangles.size(), 3);
    cube.labels[0] = 7;
    write_mesh(folder / "in.mesh", cube);
    CHECK_THAT(run(folder, "remesh in.mesh -o out.stl").err,
               Catch::Contains("labels are left behind, out.stl can hold none"));
    CHECK_THAT(run(folder, "remesh in.mesh -o out.mesh").err, !Catch::Contains("labels"));
}

TEST_CASE("sizes do not put their background in the place of another mesh", "[cli]") {
    const TemporaryFolder folder;
    write_mesh(folder / "in.off", triangulations::soup(triangulations::cube(1)));
    write_mesh(folder / "keep.mesh", triangulations::soup(triangulations::cube(2)));
    const Outcome refused = run(folder, "sizemap in.off -o keep.sol");
    CHECK(refused.code != 0);
    CHECK_THAT(refused.err, Catch::Contains("keep.mesh: exists"));
    CHECK(run(folder, "sizemap in.off -o other.sol").code == 0);
    CHECK(run(folder, "sizemap in.off -o other.sol").code == 0);
}

TEST_CASE("flat ends are flat, whatever meets them", "[cli]") {
    const TemporaryFolder folder;
    SECTION("a square bar, twisted so coarsely that its sides are folded") {
        write_mesh(folder / "in.off", parts::twisted({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}, 7.5, std::numbers::pi, 36));
        const Outcome ran = run(folder, "remesh in.off -o out.off --json");
        REQUIRE(ran.code == 0);
        CHECK(json::parse(ran.out)["feature_curves"] >= 8);
        for (const Eigen::Vector3d& p : read_mesh(folder / "out.off").points)
            CHECK((p.z() > -1e-12 && p.z() < 7.5 + 1e-12));
    }
    SECTION("a cone, cut off where it turns by less than creases do") {
        const double top = 2 * std::tan(39.8 * std::numbers::pi / 180);
        write_mesh(folder / "in.off", parts::revolved({{3, 0}, {1, top}}, 24));
        const Outcome ran = run(folder, "remesh in.off -o out.off --json");
        REQUIRE(ran.code == 0);
        CHECK(json::parse(ran.out)["feature_curves"] == 2);
        for (const Eigen::Vector3d& p : read_mesh(folder / "out.off").points)
            if (p.head<2>().norm() < 0.95) CHECK((std::abs(p.z() - top) < 1e-12 || std::abs(p.z()) < 1e-12));
    }
}
