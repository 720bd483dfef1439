#include "gradus/io/size_view.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "gradus/io/error.hpp"
#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "support/files.hpp"
#include "support/soups.hpp"

using namespace gradus;

TEST_CASE("a view of sizes for Gmsh holds them, as triangles or on the mesh", "[io]") {
    const support::TemporaryFolder folder;
    const TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 0.1, 1e-300}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}}};
    const std::vector<double> sizes{0.1, 2, std::numeric_limits<double>::infinity(), 1e-5};
    write_size_view(folder / "a.pos", soup, sizes);
    CHECK(read_file(folder / "a.pos") ==
          "View \"size\" "
          "{\nST(0,0,0,1,0,0,0,0.1,1e-300){0.1,2,1e+22};\nST(1,0,0,1,1,0,0,0.1,1e-300){2,1e-05,1e+22};\n};\n");
    write_size_view(folder / "a.msh", soup, sizes);
    const MeshData data = read_mesh_data(folder / "a.msh");
    CHECK(data.soup.points == soup.points);
    CHECK(data.soup.triangles == soup.triangles);
    REQUIRE(data.point_fields.size() == 1);
    CHECK(data.point_fields[0].name == "size");
    CHECK(data.point_fields[0].values == std::vector{0.1, 2.0, 1e22, 1e-5});

    CHECK_THROWS_AS(write_size_view(folder / "a.sol", soup, sizes), IoError);
    CHECK_THROWS_AS(write_size_view(folder / "a.pos", soup, std::vector{1.0}), std::invalid_argument);
    CHECK_THROWS_AS(write_size_view(folder / "a.pos", soup, std::vector{1.0, 1.0, 0.0, 1.0}), std::invalid_argument);
    CHECK_THROWS_AS(write_size_view(folder / "a.pos", soup, std::vector{1.0, 1.0, std::nan(""), 1.0}),
                    std::invalid_argument);
    CHECK_THROWS_AS(write_size_view(folder / "a.pos", {soup.points, {{0, 1, 4}}}, sizes), std::invalid_argument);
}

TEST_CASE("a coloured PLY holds the values and their colours", "[io]") {
    const support::TemporaryFolder folder;
    const TriangleSoup soup = support::wild_soup(3);
    std::vector<double> values;
    for (std::size_t i = 0; i < soup.points.size(); ++i) values.push_back(std::exp(0.1 * static_cast<double>(i)));
    values[7] = -1;  // not on a logarithmic scale
    write_coloured_ply(folder / "a.ply", soup.points, soup.triangles, values,
                       {.name = "h", .scale = Scale::Logarithmic});
    const MeshData data = read_mesh_data(folder / "a.ply");
    CHECK(support::same_points(data.soup, soup));
    CHECK(data.soup.triangles == soup.triangles);
    REQUIRE(data.point_fields.size() == 4);
    CHECK(data.point_fields[3].name == "h");
    CHECK(data.point_fields[3].values == values);
    const Range range = range_of(values, Scale::Logarithmic);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Colour colour = colour_at(ColourMap::Sequential, place_on(range, Scale::Logarithmic, values[i]));
        const float parts[3] = {colour.r, colour.g, colour.b};
        for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(data.point_fields[k].values[i] - 255 * parts[k]) <= 0.51);
    }
    CHECK_THROWS_AS(write_coloured_ply(folder / "a.obj", soup.points, soup.triangles, values), IoError);
    CHECK_THROWS_AS(write_coloured_ply(folder / "a.ply", soup.points, soup.triangles, {}), std::invalid_argument);
    CHECK_THROWS_AS(write_coloured_ply(folder / "a.ply", soup.points, soup.triangles, values, {.name = "two words"}),
                    std::invalid_argument);
}
