#include "gradus/gradation/grade.hpp"

#include "maps.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::test;

TEST_CASE("Full grading bounds edges and triangles, whichever bounds are given", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 4u));
    const auto shock = GENERATE(std::optional<double>{}, std::optional<double>{1.2}, std::optional<double>{2.});
    const auto variation = GENERATE(std::optional<double>{}, std::optional<double>{.3});
    if (!shock && !variation) return;
    const Tris t = random_tris(seed, 20, 15);
    const TriMesh mesh = t.mesh();
    std::vector<double> size = random_sizes(seed, t.points.size(), .1, 100);
    size[3] = INFINITY;
    const std::vector<double> input = size;
    const GradationResult result = grade(mesh, size, {.shock = shock, .variation = variation, .required = {}});
    CHECK(result.met);
    CHECK(result.converged);
    CHECK(result.steep_triangles == 0);
    CHECK(result.gradient_bound == std::min(shock ? std::log(*shock) : 9., variation.value_or(9.)));
    CHECK(result.after.gradient_max <= result.gradient_bound * (1 + 1e-9));
    if (shock) CHECK(result.after.shock_max <= *shock * (1 + 1e-9));
    if (variation) CHECK(result.after.variation_max <= *variation * (1 + 1e-9));
    CHECK(std::isinf(result.before.shock_max));
    CHECK(std::isinf(result.largest_factor));
    for (std::size_t v = 0; v < size.size(); ++v) CHECK(size[v] <= input[v]);
}

TEST_CASE("Exact grading meets both bounds on edges and certifies one", "[gradation][property]") {
    const Tris t = random_tris(6, 20, 15);
    const TriMesh mesh = t.mesh();
    const std::vector<double> input = random_sizes(6, t.points.size(), .1, 100);
    std::vector<double> size = input;
    GradationResult result =
        grade(mesh, size, {.method = GradationMethod::Exact, .shock = 1.5, .variation = {}, .required = {}});
    CHECK(result.met);
    CHECK(result.after.shock_max <= 1.5 * (1 + 1e-12));
    CHECK(result.steep_triangles > 0);
    CHECK(check_shock_certificate(mesh, 1.5, input, size, result.certificate) == std::nullopt);

    size = input;
    result = grade(mesh, size, {.method = GradationMethod::Exact, .shock = 1.5, .variation = .35, .required = {}});
    CHECK(result.met);
    CHECK(result.certificate.parent.empty());
    CHECK(result.after.shock_max <= 1.5 * (1 + 1e-12));
    CHECK(result.after.variation_max <= .35 * (1 + 1e-12));
}

TEST_CASE("The methods lower in the order of what they promise", "[gradation][property]") {
    const Tris t = random_tris(7, 20, 15);
    const TriMesh mesh = t.mesh();
    const std::vector<double> input = random_sizes(7, t.points.size(), .5, 100);
    const auto graded = [&](GradationMethod method) {
        std::vector<double> size = input;
        CHECK(grade(mesh, size, {.method = method, .shock = 1.5, .variation = {}, .required = {}}).met);
        return size;
    };
    const auto exact = graded(GradationMethod::Exact), gradient = graded(GradationMethod::Gradient),
               full = graded(GradationMethod::Full), paper = graded(GradationMethod::Paper);
    for (std::size_t v = 0; v < input.size(); ++v) {
        CHECK(gradient[v] <= exact[v] * (1 + 1e-12));
        CHECK(full[v] <= gradient[v] * (1 + 1e-12));
        CHECK(paper[v] <= exact[v] * (1 + 1e-12));
    }
}

TEST_CASE("Full grading hardly depends on the numbering of vertices", "[gradation][property]") {
    const Tris t = random_tris(8, 14, 11);
    const std::vector<int> to = permutation(8, static_cast<int>(t.points.size()));
    std::vector<double> size = random_sizes(8, t.points.size(), .1, 100), moved(size.size());
    for (std::size_t v = 0; v < to.size(); ++v) moved[to[v]] = size[v];
    const GradationOptions options{.shock = 1.4, .variation = {}, .required = {}};
    grade(t.mesh(), size, options);
    grade(renumbered(t, to).mesh(), moved, options);
    for (std::size_t v = 0; v < to.size(); ++v) CHECK(moved[to[v]] == Approx(size[v]).epsilon(1e-3));
}

TEST_CASE("Grading reports conflicts of required sizes", "[gradation]") {
    const Tris t = grid(10, 10, 1);
    const TriMesh mesh = t.mesh();
    const auto method = GENERATE(GradationMethod::Full, GradationMethod::Exact);
    std::vector<double> size(t.points.size(), INFINITY);
    size[60] = .5;
    size[62] = 4;
    const GradationResult result =
        grade(mesh, size, {.method = method, .shock = 1.5, .variation = {}, .required = {60, 62}});
    CHECK(size[60] == .5);
    CHECK(size[62] == 4);
    CHECK_FALSE(result.met);
    REQUIRE(result.conflicts.size() == 1);
    CHECK(result.conflicts[0].vertex == 62);
    CHECK(result.conflicts[0].origin == 60);
    CHECK(result.conflicts[0].needed < 2);
}

TEST_CASE("Grading refuses what makes no sense", "[gradation]") {
    const TriMesh mesh = grid(2, 2, 1).mesh();
    std::vector<double> size(9, 1);
    const auto refused = [&](const GradationOptions& options) {
        CHECK_THROWS_AS(grade(mesh, size, options), std::invalid_argument);
    };
    refused({});
    refused({.shock = 1., .variation = {}, .required = {}});
    refused({.shock = std::nan(""), .variation = {}, .required = {}});
    refused({.shock = 2., .variation = 0., .required = {}});
    refused({.method = GradationMethod::Paper, .shock = 2., .variation = {}, .required = {1}});
    refused({.shock = 2., .variation = {}, .required = {9}});
    size[2] = std::nan("");
    CHECK_THROWS_WITH(grade(mesh, size, {.shock = 2., .variation = {}, .required = {}}), Catch::Contains("vertex 2"));
}
