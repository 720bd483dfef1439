#include "gradus/io/report_json.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace gradus;

namespace {

const std::vector<Eigen::Vector3d> kPoints{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
const std::vector<Triangle> kTriangles{{0, 1, 2}, {1, 3, 2}};

}  // namespace

TEST_CASE("a report in JSON has its keys in order, null where nothing was measured", "[io]") {
    MeshReport report = measure({kPoints, kTriangles});
    report.stages = {{"read", .5}, {"write", .25}};
    const auto json = nlohmann::ordered_json::parse(to_json(report));
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    CHECK(keys == std::vector<std::string>{"topology", "shape", "edges", "offenders", "gradation", "distance",
                                           "normals", "reference", "stages"});
    CHECK(json["edges"].is_null());
    CHECK(json["distance"].is_null());
    CHECK(json["topology"]["triangles"] == 2);
    CHECK(json["topology"]["genus"] == 0);
    CHECK(json["topology"]["boundary_loops"] == 1);
    CHECK(json["shape"]["area_length"]["min"].get<double>() == Approx(std::sqrt(3.) / 2));
    CHECK(json["shape"]["worst"].size() == 2);
    CHECK(json["gradation"]["worst"][0]["edge"].size() == 2);
    CHECK(json["stages"][1]["name"] == "write");
    CHECK(to_json(report) == to_json(report));
}

TEST_CASE("numbers that are not finite are null in JSON", "[io]") {
    const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    const std::vector<Triangle> triangles{{0, 1, 2}};
    const auto json = nlohmann::json::parse(to_json(measure({points, triangles}), -1));
    CHECK(json["shape"]["adjacent_edge_ratio"]["max"].is_null());
    CHECK(json["shape"]["interior_valence"]["mean"].is_null());
    CHECK(json["shape"]["area_length"]["min"] == 0);
}
