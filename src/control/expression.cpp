#include "gradus/control/expression.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <list>
#include <map>
#include <numbers>

namespace gradus {

namespace {

constexpr double kMostAspect = 1e6;

[[noreturn]] void fail_at(const std::string& text, std::size_t column, const std::string& what) {
    throw ExpressionError(fmt::format("\"{}\": column {}: {}", text, column + 1, what));
}

[[noreturn]] void fail_there(const std::string& text, const Eigen::Vector3d& p, const std::string& what) {
    throw ExpressionError(fmt::format("\"{}\" at ({:g}, {:g}, {:g}): {}", text, p.x(), p.y(), p.z(), what));
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool is_in_name(char c) { return is_letter(c) || std::isdigit(static_cast<unsigned char>(c)); }

// What is between semicolons: `name =` before its formula, or only a formula.
struct Statement {
    std::string name, formula;
    std::size_t name_column = 0, column = 0;  // where they begin
};

// The name that a helper is given, which ends before a single `=`.
void take_name(const std::string& text, Statement& statement) {
    const std::string& s = statement.formula;
    std::size_t i = s.find_first_not_of(" \t\n");
    if (i == std::string::npos || !is_letter(s[i])) return;
    std::size_t end = i;
    while (end < s.size() && is_in_name(s[end])) ++end;
    const std::size_t equals = s.find_first_not_of(" \t\n", end);
    if (equals == std::string::npos || s[equals] != '=' || (equals + 1 < s.size() && s[equals + 1] == '=')) return;
    statement.name = s.substr(i, end - i);
    statement.name_column = statement.column + i;
    if (statement.name == "x" || statement.name == "y" || statement.name == "z")
        fail_at(text, statement.name_column, statement.name + " is a coordinate and cannot be given a value");
    statement.column += equals + 1;
    statement.formula = s.substr(equals + 1);
}

std::vector<Statement> statements_of(const std::string& text) {
    // Comments become blanks, so that columns stay.
    std::string code = text;
    for (std::size_t i = 0; i < code.size(); ++i)
        if (code[i] == '#')
            for (; i < code.size() && code[i] != '\n'; ++i) code[i] = ' ';
    for (char& c : code)
        if (c == '\n' || c == '\t' || c == '\r') c = ' ';
    std::vector<Statement> statements;
    for (std::size_t begin = 0; begin <= code.size();) {
        const std::size_t end = std::min(code.find(';', begin), code.size());
        Statement statement{{}, code.substr(begin, end - begin), 0, begin};
        if (statement.formula.find_first_not_of(' ') != std::string::npos) {
            take_name(text, statement);
            statements.push_back(std::move(statement));
        } else if (end < code.size()) {
            fail_at(text, end, "nothing before this semicolon");
        }
        begin = end + 1;
    }
    if (statements.empty()) fail_at(text, 0, "there is no formula");
    return statements;
}

std::string message_of(const mu::Parser::exception_type& error) {
    const std::string& token = error.GetToken();
    switch (error.GetCode()) {
        case mu::ecUNASSIGNABLE_TOKEN:
            return "\"" + token + "\" is not known";
        case mu::ecUNEXPECTED_EOF:
            return "the formula ends too soon";
        case mu::ecMISSING_PARENS:
            return "a parenthesis is not closed";
        case mu::ecUNEXPECTED_PARENS:
            return "this parenthesis does not belong here";
        default:
            break;
    }
    std::string what = error.GetMsg();
    if (const auto position = what.find(" at position"); position != std::string::npos) what.resize(position);
    while (!what.empty() && (what.back() == '.' || what.back() == ' ')) what.pop_back();
    return what;
}

}  // namespace

struct Expression::Compiled {
    std::array<double, 3> point{};
    std::map<std::string, double> helpers;  // whose addresses stay
    struct Step {
        mu::Parser parser;
        double* result;  // of a helper; null for the last
        std::size_t column;
    };
    std::list<Step> steps;
    std::vector<double> results;

    void add(const std::string& text, const Statement& statement) {
        Step& step = steps.emplace_back();
        step.result = nullptr;
        step.column = statement.column;
        mu::Parser& parser = step.parser;
        try {
            parser.DefineVar("x", &point[0]);
            parser.DefineVar("y", &point[1]);
            parser.DefineVar("z", &point[2]);
            for (auto& [name, value] : helpers) parser.DefineVar(name, &value);
            if (!helpers.contains("pi")) parser.DefineConst("pi", std::numbers::pi);
            parser.SetExpr(statement.formula);
            int count = 0;
            const double* values = parser.Eval(count);
            if (statement.name.empty()) {
                results.assign(values, values + count);
                return;
            }
            if (count != 1) fail_at(text, statement.column, statement.name + " is to be one value");
            step.result = &helpers[statement.name];
            *step.result = values[0];
        } catch (const mu::Parser::exception_type& error) {
            // Blanks at the end are not counted in a position there.
            const auto position = static_cast<std::size_t>(std::max(0, static_cast<int>(error.GetPos())));
            fail_at(text, std::min(statement.column + position, text.size()), message_of(error));
        }
    }
};

Expression::Expression(std::string text) : text_(std::move(text)), compiled_(std::make_unique<Compiled>()) {
    const std::vector<Statement> statements = statements_of(text_);
    for (std::size_t i = 0; i < statements.size(); ++i) {
        const bool is_last = i + 1 == statements.size();
        if (is_last != statements[i].name.empty())
            fail_at(text_, is_last ? text_.size() : statements[i].column,
                    is_last ? "the result is missing after the helper variables"
                            : "a helper variable needs a name: name = ...");
        compiled_->add(text_, statements[i]);
    }
}

Expression::Expression(const Expression& other) : Expression(other.text_) {}
Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;

int Expression::count() const { return static_cast<int>(compiled_->results.size()); }

std::span<const double> Expression::at(const Eigen::Vector3d& p) const {
    Compiled& compiled = *compiled_;
    compiled.point = {p.x(), p.y(), p.z()};
    try {
        for (Compiled::Step& step : compiled.steps) {
            int count = 0;
            const double* values = step.parser.Eval(count);
            if (step.result)
                *step.result = values[0];
            else
                std::copy(values, values + count, compiled.results.begin());
        }
    } catch (const mu::Parser::exception_type& error) {
        fail_there(text_, p, message_of(error));
    }
    return compiled.results;
}

SizeFunction<Size> size_function(const Expression& expression) {
    if (expression.count() != 1)
        throw ExpressionError(fmt::format("\"{}\": {} results; a size is one", expression.text(), expression.count()));
    return [expression](const Eigen::Vector3d& p) {
        const double h = expression.at(p)[0];
        if (!(h > 0) || !std::isfinite(h)) fail_there(expression.text(), p, fmt::format("{:g} is no size", h));
        return h;
    };
}

namespace {

Eigen::Vector3d direction(double x, double y, double z, const Eigen::Vector3d& otherwise) {
    const Eigen::Vector3d d(x, y, z);
    return d.squaredNorm() > 0 ? d.stableNormalized() : otherwise;
}

Tensor metric_from(std::span<const double> v) {
    Eigen::Matrix3d axes;
    switch (v.size()) {
        case 3:
            return planar_tensor(v[0], v[1], v[2]);
        case 4:
            axes.col(0) = direction(v[0], v[1], 0, Eigen::Vector3d::UnitX());
            axes.col(1) = Eigen::Vector3d::UnitZ().cross(axes.col(0));
            axes.col(2) = Eigen::Vector3d::UnitZ();
            return metric_along(axes, {v[2], v[3], std::sqrt(v[2] * v[3])});
        case 6:
            return {{v[0], v[1], v[2], v[3], v[4], v[5]}};
        default: {
            axes.col(0) = direction(v[0], v[1], v[2], Eigen::Vector3d::UnitX());
            Eigen::Vector3d e = direction(v[3], v[4], v[5], Eigen::Vector3d::UnitY());
            e -= e.dot(axes.col(0)) * axes.col(0);
            axes.col(1) = e.squaredNorm() > 0 ? e.stableNormalized() : axes.col(0).unitOrthogonal().eval();
            axes.col(2) = axes.col(0).cross(axes.col(1));
            return metric_along(axes, {v[6], v[7], v[8]});
        }
    }
}

bool has_sizes(std::span<const double> v) {
    const std::size_t first = v.size() == 4 ? 2 : v.size() == 9 ? 6 : v.size();
    for (std::size_t k = first; k < v.size(); ++k)
        if (!(v[k] > 0)) return false;
    return true;
}

}  // namespace

SizeFunction<SizeTensor> metric_function(const Expression& expression) {
    const int count = expression.count();
    if (count != 3 && count != 4 && count != 6 && count != 9)
        throw ExpressionError(
            fmt::format("\"{}\": {} results; a metric is m11, m12, m22, or dx, dy, h1, h2, in space 6 entries, or 2 "
                        "directions and 3 "
                        "sizes",
                        expression.text(), count));
    return [expression](const Eigen::Vector3d& p) {
        const std::span<const double> v = expression.at(p);
        const auto given = [&] { return fmt::format("{:g}", fmt::join(v, ", ")); };
        if (!has_sizes(v)) fail_there(expression.text(), p, given() + " has a size that is not positive");
        const Tensor metric = metric_from(v);
        if (!is_positive_definite(metric))
            fail_there(expression.text(), p, given() + " is no metric: it is not positive definite");
        const Tensor size = size_tensor(metric);
        const Eigen::Vector3d h = axes_of(size).values;
        if (!(h[2] <= kMostAspect * h[0]))
            fail_there(expression.text(), p,
                       fmt::format("sizes from {:g} to {:g}: more than 1e6 times as large", h[0], h[2]));
        return size;
    };
}

}  // namespace gradus
