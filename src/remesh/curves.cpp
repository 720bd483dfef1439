#include "gradus/remesh/curves.hpp"

#include "../control/patch_meshes.hpp"

#include <algorithm>
#include <cmath>

namespace gradus {

namespace {

constexpr double kLongestStep = 0.25;  // metric length of a step of the integration
constexpr double kAccuracy = 1e-3;     // change of a step's length by halving it that is good enough, in metric length
constexpr int kDeepest = 40;           // halvings of the curve

// Integrates the metric length along a curve: length[i] is that from 0 to t[i].
struct Integral {
    std::vector<double> t, length;
};

class Integrator {
  public:
    Integrator(const SurfaceModel& model, const ControlSpace& control, int curve)
        : model_(model), control_(control), curve_(curve) {
        cell_ = control.locate(model.on_curve(curve, 0, 0));
    }

    Integral run() {
        integral_ = {{0}, {0}};
        const int pieces = model_.num_patches() > SurfaceModel::kMany ? 1 : 8;
        double f0 = density(0);
        for (int i = 0; i < pieces; ++i) {
            const double b = (i + 1.0) / pieces;
            const double f1 = density(b);
            step(static_cast<double>(i) / pieces, b, f0, f1, 0);
            f0 = f1;
        }
        return std::move(integral_);
    }

  private:
    // Metric length per unit of t.
    double density(double t) {
        const CurveJet jet = model_.curve_jet(curve_, t);
        return jet.d.norm() / control_.size(jet.p, cell_);
    }

    void step(double a, double b, double fa, double fb, int depth) {
        const double m = (a + b) / 2, fm = density(m);
        const double coarse = (fa + fb) / 2 * (b - a), fine = (fa + 4 * fm + fb) / 6 * (b - a);
        if (depth < kDeepest && (fine > kLongestStep || std::abs(fine - coarse) > kAccuracy)) {
            step(a, m, fa, fm, depth + 1);
            step(m, b, fm, fb, depth + 1);
            return;
        }
        integral_.t.push_back(b);
        integral_.length.push_back(integral_.length.back() + fine);
    }

    const SurfaceModel& model_;
    const ControlSpace& control_;
    int curve_, cell_;
    Integral integral_;
};

std::vector<double> equal_pieces(const Integral& integral, int pieces) {
    std::vector<double> t{0};
    const double total = integral.length.back();
    std::size_t i = 1;
    for (int k = 1; k < pieces; ++k) {
        const double wanted = total * k / pieces;
        while (i + 1 < integral.t.size() && integral.length[i] < wanted) ++i;
        const double l0 = integral.length[i - 1], l1 = integral.length[i];
        const double s = l1 > l0 ? (wanted - l0) / (l1 - l0) : 0.5;
        t.push_back(integral.t[i - 1] + s * (integral.t[i] - integral.t[i - 1]));
    }
    t.push_back(1);
    return t;
}

}  // namespace

std::vector<std::vector<double>> discretise_curves(const SurfaceModel& model, const ControlSpace& control) {
    const auto& curves = model.curves();
    std::vector<Integral> integrals(curves.size());
    std::vector<int> pieces(curves.size(), 0);
    for (std::size_t c = 0; c < curves.size(); ++c) {
        if (curves[c].kind == CurveKind::Pole) continue;
        integrals[c] = Integrator(model, control, static_cast<int>(c)).run();
        pieces[c] = static_cast<int>(std::lround(integrals[c].length.back()));
    }
    cut_into_polygons(model, pieces);
    std::vector<std::vector<double>> t(curves.size());
    for (std::size_t c = 0; c < curves.size(); ++c)
        if (pieces[c] > 0) t[c] = equal_pieces(integrals[c], pieces[c]);
    return t;
}

}  // namespace gradus
