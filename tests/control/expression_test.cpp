#include "gradus/control/expression.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

using namespace gradus;
using Eigen::Vector3d;

namespace {

double ring(const Vector3d& p) {
    const double r2 = p.x() * p.x() + p.y() * p.y();
    return r2 >= .99 && r2 <= 1.01 ? .005 : r2 > 1.01 ? 1.0 : .1;
}

std::string error_of(const std::string& text) {
    try {
        const Expression expression(text);
    } catch (const ExpressionError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("Formulas have the values that they say", "[exact]") {
    const Expression text("# three sizes\nr2 = x^2+y^2;\n(r2 >= .99 && r2 <= 1.01) ? .005 : (r2 > 1.01 ? 1 : .1)");
    CHECK(text.count() == 1);
    const auto size = size_function(text);
    const auto copy = size_function(Expression(text));
    for (double x = -2; x <= 2; x += 0.0173)
        for (const double y : {-0.3, 0.0, 0.9}) {
            CHECK(size({x, y, 0}) == ring({x, y, 0}));
            CHECK(copy({x, y, 0}) == ring({x, y, 0}));
        }
    CHECK(Expression("2*pi*z").at({0, 0, 3})[0] == Approx(6 * 3.14159265358979).epsilon(1e-14));
    CHECK(Expression("a = 2; b = a^2; min(b, 7), max(x, y), atan2(1, 1)").at({1, 5, 0})[1] == 5);
}

TEST_CASE("Metrics by entries and by directions are the same metric", "[exact]") {
    const auto along = metric_function(Expression("c = 3; x, y, .5, 2"));
    for (const Vector3d& p : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(3, 4, 0)}) {
        const Tensor metric = metric_of(along(p));
        CHECK(size_along(metric, p) == Approx(.5).epsilon(1e-12));
        CHECK(size_along(metric, Vector3d(-p.y(), p.x(), 0)) == Approx(2).epsilon(1e-12));
    }
    CHECK(size_along(metric_of(along({0, 0, 0})), Vector3d::UnitX()) == Approx(.5));
    const Tensor by_entries = metric_of(metric_function(Expression("4, 0, .25"))({0, 0, 0}));
    CHECK(size_along(by_entries, Vector3d::UnitX()) == Approx(.5));
    CHECK(size_along(by_entries, Vector3d::UnitY()) == Approx(2));
    const Tensor space = metric_of(metric_function(Expression("0,0,1, 1,0,5, .1,.2,.3"))({0, 0, 0}));
    CHECK(size_along(space, Vector3d::UnitZ()) == Approx(.1));
    CHECK(size_along(space, Vector3d::UnitX()) == Approx(.2));
    CHECK(size_along(space, Vector3d::UnitY()) == Approx(.3));
}

TEST_CASE("Errors name the column and what is wrong", "[exact]") {
    CHECK(error_of("1/(x").find("column 5") != std::string::npos);
    CHECK(error_of("r = 2; q + 1").find("column 8: \"q\" is not known") != std::string::npos);
    CHECK(error_of("").find("no formula") != std::string::npos);
    CHECK(error_of("r = 2").find("result is missing") != std::string::npos);
    CHECK(error_of("x = 2; x").find("coordinate") != std::string::npos);
    CHECK(error_of("2; x").find("needs a name") != std::string::npos);
    CHECK(error_of("a = 1, 2; a").find("one value") != std::string::npos);
    CHECK(error_of("1 +").find("ends too soon") != std::string::npos);
    CHECK(error_of("x)").find("column 2") != std::string::npos);
    CHECK(error_of(";; x").find("nothing before") != std::string::npos);
    CHECK(error_of("x + y").empty());
    CHECK_THROWS_WITH(size_function(Expression("1, 2")), Catch::Contains("2 results"));
    CHECK_THROWS_WITH(metric_function(Expression("1, 2")), Catch::Contains("2 results"));
    CHECK_THROWS_WITH(size_function(Expression("x"))({-3, 0, 0}), Catch::Contains("(-3, 0, 0)"));
    CHECK_THROWS_WITH(size_function(Expression("1/x"))({0, 0, 0}), Catch::Contains("no size"));
    CHECK_THROWS_WITH(metric_function(Expression("1, 2, 1"))({0, 0, 0}), Catch::Contains("not positive definite"));
    CHECK_THROWS_WITH(metric_function(Expression("1, 0, 1, 3e6"))({0, 0, 0}), Catch::Contains("1e6"));
    CHECK_THROWS_WITH(metric_function(Expression("1, 0, 1, -1"))({0, 0, 0}), Catch::Contains("not positive"));
}

TEST_CASE("Copies are for threads of their own", "[property]") {
    const Expression one("s = x*x; s + y > .5 ? s : 1 + s");
    std::vector<std::thread> threads;
    std::array<int, 4> wrong{};
    for (int k = 0; k < 4; ++k)
        threads.emplace_back([&wrong, k, copy = one] {
            for (int i = 0; i < 20000; ++i) {
                const double x = 1e-4 * i, y = 0.1 * k, s = x * x;
                wrong[k] += copy.at({x, y, 0})[0] != (s + y > .5 ? s : 1 + s);
            }
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(wrong == std::array<int, 4>{});
}
