#include "gradus/mesh/flats.hpp"

#include <catch2/catch.hpp>
#include <numbers>

#include "gradus/mesh/features.hpp"
#include "support/parts.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Found {
    TriangleSoup soup;
    Connectivity mesh;
    PlanarRegions regions;
    FlatFaces flats;

    explicit Found(TriangleSoup given)
        : soup(std::move(given)),
          mesh(static_cast<int>(soup.points.size()), soup.triangles),
          regions(soup.points, mesh),
          flats(find_flat_faces(soup.points, mesh, regions)) {}
};

}  // namespace

TEST_CASE("what a round of equal turns explains leaves nothing, what a bend of planes has is left whole", "[exact]") {
    const BendSide facet{1, 1, 0.2, 1}, plane{10, 10, 0, 0};
    CHECK(unexplained_turn(0.2, facet, facet) == Approx(0).margin(1e-15));
    // Between a plane and a round the turn is half of the next.
    CHECK(unexplained_turn(0.1, plane, facet) == Approx(0).margin(1e-15));
    CHECK(unexplained_turn(0.5, plane, facet) == Approx(0.4));
    CHECK(unexplained_turn(0.3, plane, {12, 12, std::numbers::pi / 2, 5}) == Approx(0.3));
    // A round is no round the other way.
    CHECK(unexplained_turn(0.2, {1, 1, -0.2, 1}, {1, 1, -0.2, 1}) == Approx(0.2));
    // Nor is a single facet between two planes, one of which a crease cuts off beside it.
    CHECK(unexplained_turn(0.7, plane, {1, 1, 0.7, 10}) == Approx(0.7));
    CHECK(unexplained_turn(0.7, {0.5, 10, std::numbers::pi / 2, 1}, {1, 1, 0.7, 10}) == Approx(0.7));
}

TEST_CASE("the flat faces of a rounded box are its six planes, whatever needles fill them", "[exact]") {
    const double radius = GENERATE(0.01, 1.0, 10.0);
    const int facets = GENERATE(3, 6, 12);
    CAPTURE(radius, facets);
    const Found box(parts::prism(parts::rounded(100, 80, radius, facets), 60));
    REQUIRE(box.flats.normals.size() == 6);
    for (const Vector3d& n : box.flats.normals) CHECK(n.cwiseAbs().maxCoeff() == Approx(1).epsilon(1e-12));
    // The rounds are none.
    int round = 0;
    for (int t = 0; t < box.mesh.num_triangles(); ++t) round += box.flats.of(t) < 0;
    CHECK(round == 4 * facets * 2);
}

TEST_CASE("a sampled surface has no flat faces", "[property]") {
    CHECK(Found(triangulations::soup(triangulations::sphere(4))).flats.empty());
    CHECK(Found(triangulations::soup(triangulations::torus(60, 20))).flats.empty());
    CHECK(Found(parts::prism(parts::polygon(16), 2)).flats.normals.size() == 2);
}

TEST_CASE("a slab that is bent has a ridge there, a row of bends has none", "[exact]") {
    const auto bent = [](int bends, double degrees) {
        // Strips of width 1 along y, each turned by so many degrees against the last.
        TriangleSoup soup;
        Vector3d at = Vector3d::Zero();
        for (int i = 0; i <= bends + 1; ++i) {
            soup.points.push_back(at);
            soup.points.push_back(at + Vector3d(0, 5, 0));
            at += Vector3d(std::cos(i * degrees * kDegree), 0, -std::sin(i * degrees * kDegree));
        }
        for (int i = 0; i <= bends; ++i)
            soup.triangles.insert(soup.triangles.end(), {{2 * i, 2 * i + 2, 2 * i + 3}, {2 * i, 2 * i + 3, 2 * i + 1}});
        return soup;
    };
    const auto creases = [](const TriangleSoup& soup) {
        Connectivity mesh(static_cast<int>(soup.points.size()), soup.triangles);
        find_features(soup.points, mesh);
        int count = 0;
        for (int h = 0; h < 3 * mesh.num_triangles(); ++h) count += mesh.twin(h) > h && mesh.tag(h) >= 0;
        return count;
    };
    for (const double degrees : {3., 10., 20., 39.}) {
        CAPTURE(degrees);
        CHECK(creases(bent(1, degrees)) == 1);
        CHECK(creases(bent(8, degrees)) == 0);
    }
}

TEST_CASE("coordinates tell how they were rounded", "[exact]") {
    std::vector<Vector3d> points{{0.1, 2.0 / 3, -7.25}, {1e-3, 5.5, 0.3}};
    CHECK(resolution_of(points) < 1e-14);
    const std::vector<Vector3d> single{{0.1f, 2.0f / 3, -7.25f}, {1e-3f, 5.5f, 0.3f}};
    CHECK(resolution_of(single) == Approx(6e-8 * 7.25));
    for (Vector3d& p : points) p = (p * 1e6).array().round().matrix() / 1e6;
    CHECK(resolution_of(points) == Approx(0.5e-6));
}
