#include "gradus/remesh/curves.hpp"

#include "gradus/control/geometric_size.hpp"
#include "remesh/judged.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace gradus;
using namespace gradus::testing;

namespace {

/// Metric length of a piece of a curve, by many small chords.
double metric_length_of(const SurfaceModel& model, const ControlSpace& control, int curve, double t0, double t1) {
    constexpr int n = 400;
    double length = 0;
    int cell = control.locate(model.on_curve(curve, 0, t0));
    for (int i = 0; i < n; ++i) {
        const auto point = [&](double s) { return model.position(model.on_curve(curve, 0, t0 + s * (t1 - t0))); };
        length += (point((i + 1.0) / n) - point(i / double(n))).norm() / control.size(point((i + 0.5) / n), cell);
    }
    return length;
}

}  // namespace

TEST_CASE("Curves are cut into pieces of equal metric length, as near to 1 as a whole number allows",
          "[remesh][property]") {
    for (const models::Kind& kind : models::zoo()) {
        CAPTURE(kind.name);
        const SurfaceModel model = kind.make();
        const SizedBackground sized = graded_background(model, kind.size);
        const ControlSpace control(sized.background, sized.sizes);
        const auto cuts = discretise_curves(model, control);
        REQUIRE(cuts.size() == model.curves().size());
        for (int c = 0; c < static_cast<int>(cuts.size()); ++c) {
            if (model.curves()[c].kind == CurveKind::Pole) {
                CHECK(cuts[c].empty());
                continue;
            }
            CAPTURE(c, cuts[c].size());
            const auto& t = cuts[c];
            REQUIRE(t.size() >= 2);
            CHECK(t.front() == 0);
            CHECK(t.back() == 1);
            double total = 0, shortest = 1e9, longest = 0;
            for (std::size_t i = 0; i + 1 < t.size(); ++i) {
                CHECK(t[i] < t[i + 1]);
                const double length = metric_length_of(model, control, c, t[i], t[i + 1]);
                total += length;
                shortest = std::min(shortest, length);
                longest = std::max(longest, length);
            }
            CHECK(longest <= 1.02 * shortest);
            const double pieces = static_cast<double>(t.size() - 1);
            if (total > 3.5) CHECK(std::abs(total - pieces) <= 0.55);
        }
    }
}

TEST_CASE("A straight side of uniform size is cut evenly", "[remesh][exact]") {
    const SurfaceModel model = models::model_of({models::flat_square()});
    const SizedBackground sized = uniform_background(model, 0.1);
    for (const auto& t : discretise_curves(model, ControlSpace(sized.background, sized.sizes))) {
        REQUIRE(t.size() == 11);
        for (int i = 0; i <= 10; ++i) CHECK(t[i] == Approx(i / 10.0).margin(1e-6));
    }
    // The uneven parametrisation has the same points in space.
    const SurfaceModel uneven = models::model_of({models::uneven_square()});
    const SizedBackground of_uneven = uniform_background(uneven, 0.1);
    const auto cuts = discretise_curves(uneven, ControlSpace(of_uneven.background, of_uneven.sizes));
    for (int c = 0; c < 4; ++c) {
        REQUIRE(cuts[c].size() == 11);
        for (int i = 0; i < 10; ++i) {
            const auto point = [&](int k) { return uneven.position(uneven.on_curve(c, 0, cuts[c][k])); };
            CHECK((point(i + 1) - point(i)).norm() == Approx(0.1).epsilon(5e-3));
        }
    }
}

TEST_CASE("However large the sizes, loops and seams stay polygons", "[remesh][property]") {
    for (const models::Kind& kind : models::zoo()) {
        CAPTURE(kind.name);
        const SurfaceModel model = kind.make();
        const SizedBackground sized = uniform_background(model, 1000 * kind.size);
        const auto cuts = discretise_curves(model, ControlSpace(sized.background, sized.sizes));
        for (std::size_t c = 0; c < cuts.size(); ++c) {
            const ModelCurve& curve = model.curves()[c];
            if (curve.kind == CurveKind::Pole) continue;
            const bool seam = curve.uses.size() == 2 && curve.uses[0].patch == curve.uses[1].patch;
            const std::size_t least = curve.ends[0] == curve.ends[1] ? 3 : seam ? 2 : 1;
            CHECK(cuts[c].size() >= least + 1);
            CHECK(cuts[c].size() <= 4);
        }
    }
}
