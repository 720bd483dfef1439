/// Sizes and metrics by formula, as users write them.
#pragma once

#include "gradus/control/sampled_background.hpp"

#include <memory>
#include <stdexcept>
#include <string>

namespace gradus {

/// One line that quotes the formula and says what is wrong: with its column where it cannot be understood, with the
/// point and the values there where it gives no size or metric.
class ExpressionError : public std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

/// A formula in x, y and z: helper variables, each `name = formula;`, then one or several results between commas. Known
/// are + - * / ^, comparisons, && || !, `condition ? a : b`, pi, and the functions of muParser: sqrt exp ln log10 abs
/// sin cos tan asin acos atan atan2 sinh cosh tanh min max sum avg sign rint. `#` and what follows in its line is left
/// out.
class Expression {
  public:
    /// @throws ExpressionError
    explicit Expression(std::string text);
    ~Expression();
    Expression(Expression&&) noexcept;
    Expression(const Expression&);

    /// Number of results.
    int count() const;
    /// The results at a point; they stay until the next call. Each copy may be used by one thread at once.
    std::span<const double> at(const Eigen::Vector3d& p) const;
    const std::string& text() const { return text_; }

  private:
    struct Compiled;
    std::string text_;
    std::unique_ptr<Compiled> compiled_;
};

/// A size, by a formula of one result. @throws ExpressionError for another number; the function where it is not > 0 and
/// finite
SizeFunction<Size> size_function(const Expression& expression);

/// A metric, by its number of results:
///   3  m11, m12, m22: in the plane
///   4  dx, dy, h1, h2: in the plane, the size h1 along the direction d, of any length, and h2 across it
///   6  m11, m12, m22, m13, m23, m33: in space
///   9  two directions d and e, three sizes: along d, along what of e is orthogonal to d, and across both
/// A direction that is zero is the x axis, or the y axis for e.
/// @throws ExpressionError for another number; the function where that is no metric (is_positive_definite) or one size
/// is more than 1e6 times another
SizeFunction<SizeTensor> metric_function(const Expression& expression);

}  // namespace gradus
