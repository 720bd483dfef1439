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
        if (pieces[c] > 0) t[c] = equal_pieces(integrals[c].t, integrals[c].length, pieces[c]);
    return t;
}

}  // namespace gradus
