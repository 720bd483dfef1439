#include "gradus/surface/bezier_patch.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace gradus {
namespace {

// Coordinates are padded to four (the fourth is the weight, or unused), so that sums of points are whole vector
// operations.
using Point4 = Eigen::Vector4d;

// Sums pair the points of either end, so that a curve run backwards (1 - t for t) gives the same bits: addition
// commutes. At t = 0 and t = 1 all weights but one are exactly zero: end points are interpolated exactly. Both would be
// lost to fused multiply-add, which src/surface/CMakeLists.txt turns off for this file.

// -- Bicubic, polynomial: everything unrolled
// ---------------------------------------------------------------------------------

struct CubicWeights {
    double b0, b1, b2, b3;

    explicit CubicWeights(double t) {
        const double s = 1 - t;
        const double tt = t * t, ss = s * s;
        b0 = ss * s;
        b1 = 3 * (ss * t);
        b2 = 3 * (tt * s);
        b3 = tt * t;
    }
    template <class Points>
    Point4 sum(const Points& p) const {
        return (b0 * p(0) + b3 * p(3)) + (b1 * p(1) + b2 * p(2));
    }
};

struct QuadraticWeights {
    double b0, b1, b2;

    explicit QuadraticWeights(double t) : b0((1 - t) * (1 - t)), b1(2 * (t * (1 - t))), b2(t * t) {}
    template <class Points>
    Point4 sum(const Points& p) const {
        return (b0 * p(0) + b2 * p(2)) + b1 * p(1);
    }
};

class BicubicPatch final : public ParametricSurface {
  public:
    explicit BicubicPatch(const BezierNet& net) {
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) net_[j][i] << net.points[4 * j + i], 0;
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 4; ++i) net_v_[j][i] = 3 * (net_[j + 1][i] - net_[j][i]);
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 4; ++i) net_vv_[j][i] = 2 * (net_v_[j + 1][i] - net_v_[j][i]);
    }

    Domain domain() const override { return {}; }

    Eigen::Vector3d position(const Eigen::Vector2d& uv) const override {
        const CubicWeights bu(uv.x()), bv(uv.y());
        Point4 q[4];
        for (int i = 0; i < 4; ++i) q[i] = bv.sum([&](int j) -> const Point4& { return net_[j][i]; });
        return bu.sum([&](int i) -> const Point4& { return q[i]; }).head<3>();
    }

    Jet1 jet1(const Eigen::Vector2d& uv) const override {
        const CubicWeights bu(uv.x()), bv(uv.y());
        const QuadraticWeights cu(uv.x()), cv(uv.y());
        Point4 q[4], qv[4];
        for (int i = 0; i < 4; ++i) q[i] = bv.sum([&](int j) -> const Point4& { return net_[j][i]; });
        for (int i = 0; i < 4; ++i) qv[i] = cv.sum([&](int j) -> const Point4& { return net_v_[j][i]; });
        const Point4 d[3] = {q[1] - q[0], q[2] - q[1], q[3] - q[2]};

        Jet1 jet;
        jet.p = bu.sum([&](int i) -> const Point4& { return q[i]; }).head<3>();
        jet.du = (3 * cu.sum([&](int i) -> const Point4& { return d[i]; })).head<3>();
        jet.dv = bu.sum([&](int i) -> const Point4& { return qv[i]; }).head<3>();
        return jet;
    }

    Jet2 jet2(const Eigen::Vector2d& uv) const override { return second_order(uv); }

    void jets(std::span<const Eigen::Vector2d> uv, std::span<Jet2> jets) const override {
        for (std::size_t i = 0; i < uv.size(); ++i) jets[i] = second_order(uv[i]);
    }

  private:
    Jet2 second_order(const Eigen::Vector2d& uv) const {
        const double u = uv.x(), v = uv.y();
        const CubicWeights bu(u), bv(v);
        const QuadraticWeights cu(u), cv(v);
        Point4 q[4], qv[4], qvv[4];
        for (int i = 0; i < 4; ++i) q[i] = bv.sum([&](int j) -> const Point4& { return net_[j][i]; });
        for (int i = 0; i < 4; ++i) qv[i] = cv.sum([&](int j) -> const Point4& { return net_v_[j][i]; });
        for (int i = 0; i < 4; ++i) qvv[i] = (1 - v) * net_vv_[0][i] + v * net_vv_[1][i];
        const Point4 d[3] = {q[1] - q[0], q[2] - q[1], q[3] - q[2]};
        const Point4 dv[3] = {qv[1] - qv[0], qv[2] - qv[1], qv[3] - qv[2]};

        Jet2 jet;
        jet.p = bu.sum([&](int i) -> const Point4& { return q[i]; }).head<3>();
        jet.du = (3 * cu.sum([&](int i) -> const Point4& { return d[i]; })).head<3>();
        jet.dv = bu.sum([&](int i) -> const Point4& { return qv[i]; }).head<3>();
        jet.duu = (6 * ((1 - u) * (d[1] - d[0]) + u * (d[2] - d[1]))).head<3>();
        jet.duv = (3 * cu.sum([&](int i) -> const Point4& { return dv[i]; })).head<3>();
        jet.dvv = bu.sum([&](int i) -> const Point4& { return qvv[i]; }).head<3>();
        return jet;
    }

    Point4 net_[4][4];     // [j][i]: j along v, i along u
    Point4 net_v_[3][4];   // its derivative along v
    Point4 net_vv_[2][4];  // and the second
};

// -- Any degree, rational or not
// ----------------------------------------------------------------------------------------------

/// Bernstein polynomials of one degree at one parameter.
struct Weights {
    std::array<double, max_bezier_degree + 1> b;
    int degree;

    Weights(int n, double t) : degree(n) {
        std::array<double, max_bezier_degree + 1> power_t, power_s;
        power_t[0] = power_s[0] = 1;
        for (int i = 1; i <= n; ++i) {
            power_t[i] = power_t[i - 1] * t;
            power_s[i] = power_s[i - 1] * (1 - t);
        }
        double binomial = 1;
        for (int i = 0; i <= n; ++i) {
            b[i] = binomial * (power_t[i] * power_s[n - i]);
            binomial = std::round(binomial * (n - i) / (i + 1));  // exact: below 2^53 up to the largest degree
        }
    }

    template <class Points>
    Point4 sum(const Points& p) const {
        Point4 result = Point4::Zero();
        for (int i = 0; 2 * i < degree; ++i) result += b[i] * p(i) + b[degree - i] * p(degree - i);
        if (degree % 2 == 0) result += b[degree / 2] * p(degree / 2);
        return result;
    }
};

/// Homogeneous points of a curve and of its first and second derivatives.
class GeneralPatch final : public ParametricSurface {
  public:
    explicit GeneralPatch(const BezierNet& net) : m_(net.degree_u), n_(net.degree_v), rational_(!net.weights.empty()) {
        net_.resize(net.points.size());
        for (std::size_t k = 0; k < net.points.size(); ++k) {
            const double weight = rational_ ? net.weights[k] : 1.0;
            net_[k] << weight * net.points[k], weight;
        }
        const int top = n_ * (m_ + 1);
        corners_ = {net.points[0], net.points[m_], net.points[top + m_], net.points[top]};
    }

    Domain domain() const override { return {}; }
    Eigen::Vector3d position(const Eigen::Vector2d& uv) const override { return evaluate<0>(uv).p; }
    Jet1 jet1(const Eigen::Vector2d& uv) const override {
        const Jet2 jet = evaluate<1>(uv);
        return {jet.p, jet.du, jet.dv};
    }
    Jet2 jet2(const Eigen::Vector2d& uv) const override { return evaluate<2>(uv); }

  private:
    using Row = std::array<Point4, max_bezier_degree + 1>;

    const Point4& net(int i, int j) const { return net_[j * (m_ + 1) + i]; }

    /// Jet up to `Order`; what is above is left unset.
    template <int Order>
    Jet2 evaluate(const Eigen::Vector2d& uv) const {
        const double u = uv.x(), v = uv.y();
        Row q, qv, qvv;  // points along u of the curve v = const, and their derivatives along v
        {
            const Weights b(n_, v);
            for (int i = 0; i <= m_; ++i) q[i] = b.sum([&](int j) -> const Point4& { return net(i, j); });
        }
        if constexpr (Order >= 1) {
            const Weights b(n_ - 1, v);
            for (int i = 0; i <= m_; ++i)
                qv[i] = n_ * b.sum([&](int j) -> Point4 { return net(i, j + 1) - net(i, j); });
        }
        if constexpr (Order >= 2) {
            if (n_ < 2) {
                for (int i = 0; i <= m_; ++i) qvv[i].setZero();
            } else {
                const Weights b(n_ - 2, v);
                for (int i = 0; i <= m_; ++i)
                    qvv[i] = n_ * (n_ - 1) * b.sum([&](int j) -> Point4 {
                        return (net(i, j + 2) - net(i, j + 1)) - (net(i, j + 1) - net(i, j));
                    });
            }
        }

        const Weights b0(m_, u);
        Jet2 jet;
        const Point4 p = along(b0, q);
        jet.p = rational_ ? place(uv, p) : Eigen::Vector3d(p.head<3>());
        if constexpr (Order >= 1) {
            const Weights b1(m_ - 1, u);
            const Point4 du = first_along(b1, q), dv = along(b0, qv);
            jet.du =
                rational_ ? Eigen::Vector3d((du.head<3>() - du.w() * jet.p) / p.w()) : Eigen::Vector3d(du.head<3>());
            jet.dv =
                rational_ ? Eigen::Vector3d((dv.head<3>() - dv.w() * jet.p) / p.w()) : Eigen::Vector3d(dv.head<3>());
            if constexpr (Order >= 2) {
                const Point4 duu = second_along(u, q), duv = first_along(b1, qv), dvv = along(b0, qvv);
                if (rational_) {
                    jet.duu = (duu.head<3>() - 2 * du.w() * jet.du - duu.w() * jet.p) / p.w();
                    jet.duv = (duv.head<3>() - du.w() * jet.dv - dv.w() * jet.du - duv.w() * jet.p) / p.w();
                    jet.dvv = (dvv.head<3>() - 2 * dv.w() * jet.dv - dvv.w() * jet.p) / p.w();
                } else {
                    jet.duu = duu.head<3>();
                    jet.duv = duv.head<3>();
                    jet.dvv = dvv.head<3>();
                }
            }
        }
        return jet;
    }

    Point4 along(const Weights& b, const Row& q) const {
        return b.sum([&](int i) -> const Point4& { return q[i]; });
    }
    Point4 first_along(const Weights& b, const Row& q) const {
        return m_ * b.sum([&](int i) -> Point4 { return q[i + 1] - q[i]; });
    }
    Point4 second_along(double u, const Row& q) const {
        if (m_ < 2) return Point4::Zero();
        const Weights b(m_ - 2, u);
        return m_ * (m_ - 1) * b.sum([&](int i) -> Point4 { return (q[i + 2] - q[i + 1]) - (q[i + 1] - q[i]); });
    }

    /// Point of a rational patch; (w p) / w need not be p again, so corners are taken from the net.
    Eigen::Vector3d place(const Eigen::Vector2d& uv, const Point4& p) const {
        const bool at_u = uv.x() == 0 || uv.x() == 1, at_v = uv.y() == 0 || uv.y() == 1;
        if (at_u && at_v) return corners_[uv.y() == 0 ? (uv.x() == 0 ? 0 : 1) : (uv.x() == 0 ? 3 : 2)];
        return p.head<3>() / p.w();
    }

    int m_, n_;
    bool rational_;
    std::vector<Point4> net_;
    std::array<Eigen::Vector3d, 4> corners_;
};

void check_degree(const char* name, int degree) {
    if (degree < 1 || degree > max_bezier_degree)
        throw std::invalid_argument("make_bezier_patch: " + std::string(name) + " is " + std::to_string(degree) +
                                    ", must be 1 to " + std::to_string(max_bezier_degree));
}

void check(const BezierNet& net) {
    check_degree("degree_u", net.degree_u);
    check_degree("degree_v", net.degree_v);
    const std::size_t size = static_cast<std::size_t>(net.degree_u + 1) * (net.degree_v + 1);
    if (net.points.size() != size)
        throw std::invalid_argument("make_bezier_patch: " + std::to_string(net.points.size()) + " points, must be " +
                                    std::to_string(size));
    if (!net.weights.empty() && net.weights.size() != size)
        throw std::invalid_argument("make_bezier_patch: " + std::to_string(net.weights.size()) +
                                    " weights, must be none or " + std::to_string(size));
    for (std::size_t k = 0; k < size; ++k)
        if (!net.points[k].allFinite())
            throw std::invalid_argument("make_bezier_patch: point " + std::to_string(k) + " is not finite");
    for (std::size_t k = 0; k < net.weights.size(); ++k)
        if (!(net.weights[k] > 0) || !std::isfinite(net.weights[k]))
            throw std::invalid_argument("make_bezier_patch: weight " + std::to_string(k) +
                                        " is not positive and finite");
}

}  // namespace

std::unique_ptr<const ParametricSurface> make_bezier_patch(BezierNet net) {
    check(net);
    if (net.degree_u == 3 && net.degree_v == 3 && net.weights.empty()) return std::make_unique<const BicubicPatch>(net);
    return std::make_unique<const GeneralPatch>(net);
}

}  // namespace gradus
