#include "gradus/io/patch_files.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "gradus/io/input_file.hpp"
#include "gradus/io/output_file.hpp"

namespace gradus {
namespace {

/// The lines of a file that say something, split into words, one at a time.
class LineReader {
  public:
    LineReader(std::string text, std::string path) : path_(std::move(path)), in_(std::move(text)) {}

    /// Moves to the next line with words; false at the end of the file.
    bool next() {
        std::string text;
        while (std::getline(in_, text)) {
            ++line_;
            if (const std::size_t hash = text.find('#'); hash != std::string::npos) {
                if (collects_comments_) comment_ += trimmed(text.substr(hash + 1)) + "\n";
                text.resize(hash);
            }
            split(text);
            if (!words_.empty()) return true;
        }
        words_.clear();
        return false;
    }

    void require_next(const std::string& wanted) {
        if (!next()) throw IoError(path_, line_, "the file ends where " + wanted + " should follow");
    }

    const std::vector<std::string>& words() const { return words_; }
    int line() const { return line_; }
    /// Comments met until the first count was read.
    std::string take_comment() {
        collects_comments_ = false;
        if (!comment_.empty()) comment_.pop_back();
        return std::move(comment_);
    }

    [[noreturn]] void fail(const std::string& what) const { throw IoError(path_, line_, what); }

    double number(std::size_t k) const {
        const std::string& word = words_[k];
        const char* begin = word.data() + (word[0] == '+' ? 1 : 0);
        double value = 0;
        const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size()) fail("\"" + word + "\" is not a number");
        if (!std::isfinite(value)) fail("\"" + word + "\" is not a finite number");
        return value;
    }

    int integer(std::size_t k, const std::string& name, int low, int high) const {
        const std::string& word = words_[k];
        int value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size()) fail("\"" + word + "\" is not " + name);
        if (value < low || value > high) fail(fmt::format("{} is {}, must be {} to {}", name, value, low, high));
        return value;
    }

    void require_words(std::size_t count, const std::string& wanted) const {
        if (words_.size() != count) fail(fmt::format("{} values where {} should be", words_.size(), wanted));
    }

  private:
    static std::string trimmed(const std::string& text) {
        const std::size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
        return begin == std::string::npos ? std::string() : text.substr(begin, end - begin + 1);
    }

    void split(std::string text) {
        for (char& c : text)
            if (c == ',') c = ' ';
        std::istringstream stream(text);
        words_.clear();
        for (std::string word; stream >> word;) words_.push_back(word);
    }

    std::string path_;
    std::istringstream in_;
    int line_ = 0;
    std::vector<std::string> words_;
    std::string comment_;
    bool collects_comments_ = true;
};

constexpr int most_patches = 100'000'000;  // a larger count is a broken file

/// Reads one point into the net; the first point of a net decides whether it has weights.
void read_point(const LineReader& in, BezierNet& net) {
    const std::size_t columns = in.words().size();
    if (columns != 3 && columns != 4)
        in.fail(fmt::format("{} values where a point \"x y z\" or \"x y z weight\" should be", columns));
    if (!net.points.empty() && (columns == 4) != !net.weights.empty())
        in.fail("points with and without weights in one patch");
    net.points.emplace_back(in.number(0), in.number(1), in.number(2));
    if (columns == 3) return;
    const double weight = in.number(3);
    if (!(weight > 0)) in.fail("weight " + in.words()[3] + " is not positive");
    net.weights.push_back(weight);
}

void read_points(LineReader& in, int patch, BezierNet& net, bool on_first_point) {
    const int count = (net.degree_u + 1) * (net.degree_v + 1);
    for (int k = 0; k < count; ++k) {
        if (!on_first_point || k > 0)
            in.require_next(fmt::format("point {} of {} of patch {}", k + 1, count, patch + 1));
        read_point(in, net);
    }
}

/// From the line of the first patch's degrees.
std::vector<BezierNet> read_with_degrees(LineReader& in, int count) {
    std::vector<BezierNet> nets;
    for (int patch = 0; patch < count; ++patch) {
        if (patch > 0) in.require_next(fmt::format("patch {} of {}", patch + 1, count));
        in.require_words(2, fmt::format("the two degrees of patch {}", patch + 1));
        BezierNet net;
        net.degree_u = in.integer(0, "a degree", 1, max_bezier_degree);
        net.degree_v = in.integer(1, "a degree", 1, max_bezier_degree);
        read_points(in, patch, net, false);
        nets.push_back(std::move(net));
    }
    return nets;
}

/// From the line of the first point.
std::vector<BezierNet> read_bicubic(LineReader& in, int count) {
    std::vector<BezierNet> nets;
    for (int patch = 0; patch < count; ++patch) {
        BezierNet net;
        read_points(in, patch, net, patch == 0);
        nets.push_back(std::move(net));
    }
    return nets;
}

/// From the line of the first patch's vertex numbers. Those are checked where they stand, so vertices are counted first
/// and their number is believed only once they are there.
std::vector<BezierNet> read_indexed(LineReader& in, int count, const std::string& path) {
    struct Row {
        std::array<int, 16> vertices;
        int line;
    };
    std::vector<Row> rows;
    for (int patch = 0; patch < count; ++patch) {
        if (patch > 0) in.require_next(fmt::format("patch {} of {}", patch + 1, count));
        in.require_words(16, fmt::format("the 16 vertex numbers of patch {}", patch + 1));
        Row row{{}, in.line()};
        for (int k = 0; k < 16; ++k) row.vertices[k] = in.integer(k, "a vertex number", 1, 16 * most_patches);
        rows.push_back(row);
    }
    in.require_next("the number of vertices");
    in.require_words(1, "the number of vertices");
    const int num_vertices = in.integer(0, "the number of vertices", 1, 16 * most_patches);
    for (const Row& row : rows)
        for (const int vertex : row.vertices)
            if (vertex > num_vertices)
                throw IoError(path, row.line, fmt::format("vertex {} of {}", vertex, num_vertices));

    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < num_vertices; ++k) {
        in.require_next(fmt::format("vertex {} of {}", k + 1, num_vertices));
        in.require_words(3, "a vertex \"x y z\"");
        points.emplace_back(in.number(0), in.number(1), in.number(2));
    }
    std::vector<BezierNet> nets;
    for (const Row& row : rows) {
        BezierNet net;
        for (const int vertex : row.vertices) net.points.push_back(points[vertex - 1]);
        nets.push_back(std::move(net));
    }
    return nets;
}

}  // namespace

PatchFile read_patches(const std::string& path) { return parse_patches(read_file(path), path); }

PatchFile parse_patches(const std::string& text, const std::string& path) {
    LineReader in(text, path);
    in.require_next("the number of patches");
    in.require_words(1, "the number of patches alone");
    const int count = in.integer(0, "the number of patches", 1, most_patches);
    PatchFile file;
    file.origin = in.take_comment();
    in.require_next("the first patch");
    switch (in.words().size()) {
        case 2:
            file.nets = read_with_degrees(in, count);
            break;
        case 3:
        case 4:
            file.nets = read_bicubic(in, count);
            break;
        case 16:
            file.nets = read_indexed(in, count, path);
            break;
        default:
            in.fail("neither two degrees, nor a point, nor 16 vertex numbers");
    }
    if (in.next()) in.fail(fmt::format("text after the last of {} patches", count));
    return file;
}

void write_patches(const std::string& path, const PatchFile& file) {
    std::ostringstream out;
    std::istringstream origin(file.origin);
    for (std::string line; std::getline(origin, line);) out << (line.empty() ? "#" : "# " + line) << '\n';
    out << file.nets.size() << '\n';
    for (const BezierNet& net : file.nets) {
        out << net.degree_u << ' ' << net.degree_v << '\n';
        for (std::size_t k = 0; k < net.points.size(); ++k) {
            const Eigen::Vector3d& p = net.points[k];
            out << fmt::format("{} {} {}", p.x(), p.y(), p.z());
            if (!net.weights.empty()) out << fmt::format(" {}", net.weights[k]);
            out << '\n';
        }
    }
    write_file(path, out.str());
}

SurfaceModel make_model(const PatchFile& file, const ModelOptions& options) {
    std::vector<std::unique_ptr<const ParametricSurface>> patches;
    for (const BezierNet& net : file.nets) patches.push_back(make_bezier_patch(net));
    return glue(std::move(patches), options);
}

}  // namespace gradus
