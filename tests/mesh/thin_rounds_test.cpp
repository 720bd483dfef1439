#include "gradus/mesh/thin_rounds.hpp"

#include <catch2/catch.hpp>
#include <numbers>

#include "support/parts.hpp"

using namespace gradus;

namespace {

// Of a box with rounded upright edges.
ThinRounds found_in(double radius, int facets, double height, double width) {
    const TriangleSoup box = parts::prism(parts::rounded(100, 80, radius, facets), 60);
    const Connectivity mesh(static_cast<int>(box.points.size()), box.triangles);
    const PlanarRegions regions(box.points, mesh);
    return find_thin_rounds(box.points, mesh, regions, find_flat_faces(box.points, mesh, regions), height,
                            std::vector<double>(box.points.size(), width));
}

}  // namespace

TEST_CASE("a round whose middle leaves the planes beside it by less than a height is a ridge there", "[exact]") {
    const int facets = GENERATE(1, 2, 3, 6, 7);
    const double radius = 2;
    // Of an even number of facets the middle is an edge, else the nearest one is half a facet off.
    const double angle = std::numbers::pi / 4 * (1 + (facets % 2) / double(facets)),
                 height = radius * (1 - std::cos(angle));
    const ThinRounds thin = found_in(radius, facets, height * 1.001, 0);
    CHECK(thin.ridges.size() == 4);
    CHECK(thin.others.size() == 4 * static_cast<std::size_t>(facets));
    int triangles = 0;
    for (std::size_t t = 0; t < thin.has_triangle.size(); ++t) triangles += thin.has(static_cast<int>(t));
    CHECK(triangles == 4 * facets * 2);
    CHECK(found_in(radius, facets, height * 0.999, 0).ridges.empty());
}

TEST_CASE("a round narrower than a width is a ridge too", "[exact]") {
    const int facets = GENERATE(2, 5);
    const double radius = 2, width = facets * 2 * radius * std::sin(std::numbers::pi / (4 * facets));
    CHECK(found_in(radius, facets, 0, width * 1.001).ridges.size() == 4);
    CHECK(found_in(radius, facets, 0, width * 0.999).ridges.empty());
}
