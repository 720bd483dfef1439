// Wavefront OBJ: `v` and `f` are read, with negative indices, v/vt/vn forms and lines continued by a backslash; the
// rest is passed over. Of cages of subdivision all faces are kept as they are, with `t`, the tags, and `usemtl` or `g`.
#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>

#include "formats.hpp"
#include "gradus/surface/subdivision.hpp"
#include "polygons.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

class ObjReader {
  public:
    /// @param cage  gets faces, tags and labels; null: only triangles are wanted
    ObjReader(const std::string& path, std::string_view text, Cage* cage = nullptr)
        : path_(path), in_(path, text, '#', true), cage_(cage) {}

    TriangleSoup read() {
        for (; in_.remaining() > 0; in_.next_line()) {
            if (in_.at_line_end()) continue;
            const char* word = in_.position();
            if (cage_ != nullptr) read_for_cage();
            if (!is_space_at(word + 1)) continue;  // vt, vn, usemtl ...
            if (*word == 'v') read_vertex();
            if (*word == 'f') read_face();
        }
        if (soup_.points.empty()) in_.fail_at(in_.position(), "has no vertex (no line `v x y z`)");
        if (largest_ >= soup_.points.size())
            in_.fail_at(largest_where_, "vertex " + std::to_string(largest_ + 1) + " out of range; there are " +
                                            std::to_string(soup_.points.size()));
        if (cage_ != nullptr) {
            cage_->points = soup_.points;
            if (std::all_of(cage_->labels.begin(), cage_->labels.end(),
                            [&](int label) { return label == cage_->labels[0]; }))
                cage_->labels.clear();
            return {};
        }
        clip_ears(path_, soup_, fans_);
        return std::move(soup_);
    }

  private:
    bool is_space_at(const char* at) const {
        return at == in_.position() + in_.remaining() || is_space(*at) || *at == '\\';
    }

    void read_vertex() {
        in_.advance(1);
        Eigen::Vector3d point;
        for (int i = 0; i < 3; ++i) point[i] = in_.real_in_line("a coordinate");
        // A weight or a colour may follow.
        while (!in_.at_line_end()) in_.real_here("a number");
        soup_.points.push_back(point);
    }

    void read_face() {
        in_.advance(1);
        const char* start = in_.position();
        int first = 0, previous = 0, corners = 0;
        while (!in_.at_line_end()) {
            const int vertex = read_corner();
            if (corners == 0) first = vertex;
            if (cage_ != nullptr) corners == 0 ? add_cage_face(vertex) : cage_->faces.back().push_back(vertex);
            if (corners > 1) soup_.triangles.push_back({first, previous, vertex});
            previous = vertex;
            ++corners;
        }
        if (corners > 3)
            fans_.push_back({soup_.triangles.size() - static_cast<std::size_t>(corners - 2),
                             static_cast<std::size_t>(corners - 2)});
        if (corners < 3) in_.fail_at(start, "a face needs at least 3 vertices, found " + std::to_string(corners));
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    int read_corner() {
        const char* where = in_.position();
        const char* const end = where + in_.remaining();
        const char* at = where;
        const std::int64_t index = read_index(at, end);
        for (int slashes = 0; slashes < 2 && at != end && *at == '/'; ++slashes) {
            ++at;
            const bool absent = slashes == 0 && at != end && *at == '/';
            if (!absent && (at == end || is_space(*at))) break;  // `1/` is written by some
            if (!absent) read_index(at, end);
        }
        if (at != end && !is_space(*at) && *at != '#' && *at != '\\') in_.fail_expected("a vertex of a face");
        in_.advance(static_cast<std::size_t>(at - where));
        return resolve(index, where);
    }

    std::int64_t read_index(const char*& at, const char* end) {
        const bool negative = at != end && *at == '-';
        if (negative || (at != end && *at == '+')) ++at;
        const char* first = at;
        std::int64_t value = 0;
        for (; at != end && *at >= '0' && *at <= '9'; ++at)
            if (value <= std::numeric_limits<int>::max()) value = 10 * value + (*at - '0');
        if (at == first) in_.fail_expected("a vertex of a face");
        return negative ? -value : value;
    }

    /// From 1 on, or from -1 backwards from the last vertex so far. Vertices may come later: compared at the end.
    int resolve(std::int64_t index, const char* where) {
        const auto n = static_cast<std::int64_t>(soup_.points.size());
        const std::int64_t vertex = index < 0 ? n + index : index - 1;
        if (index == 0 || vertex < 0 || vertex > std::numeric_limits<int>::max() - 1)
            in_.fail_at(
                where, "vertex " + std::to_string(index) + " out of range; there are " + std::to_string(n) + " so far");
        if (vertex >= n && static_cast<std::size_t>(vertex) > largest_) {
            largest_ = static_cast<std::size_t>(vertex);
            largest_where_ = where;
        }
        return static_cast<int>(vertex);
    }

    // Of a cage also lines `t`, its tags, and the names of materials, or of groups where there are none.
    void read_for_cage() {
        const std::string_view word = in_.peek();
        if (word == "t")
            read_tag();
        else if (word == "usemtl")
            material_ = label_of(word);
        else if (word == "g")
            group_ = label_of(word);
    }

    int label_of(std::string_view keyword) {
        in_.advance(keyword.size());
        const std::string name =
            std::string(keyword) + (in_.at_line_end() ? std::string() : std::string(in_.word("a name")));
        return names_.emplace(name, static_cast<int>(names_.size()) + 1).first->second;
    }

    void add_cage_face(int vertex) {
        cage_->faces.push_back({vertex});
        cage_->labels.push_back(material_ > 0 ? material_ : group_);
    }

    // "t name integers/reals/strings ...", as OpenSubdiv's shapes have them.
    void read_tag() {
        in_.advance(1);
        in_.at_line_end();
        const char* const where = in_.position();
        const std::string tag(in_.word("the name of a tag"));
        in_.at_line_end();
        std::size_t counts[3];
        for (int i = 0; i < 3; ++i) {
            if (i > 0) {
                if (in_.remaining() == 0 || *in_.position() != '/') in_.fail_expected("counts like 2/1/0");
                in_.advance(1);
            }
            counts[i] = read_tag_count();
        }
        std::vector<int> integers;
        std::vector<double> reals;
        for (std::size_t i = 0; i < counts[0]; ++i) integers.push_back(in_.int_in_line("a whole number"));
        for (std::size_t i = 0; i < counts[1]; ++i) reals.push_back(in_.real_in_line("a number"));
        const std::string word = counts[2] > 0 && !in_.at_line_end() ? std::string(in_.word("a word")) : std::string();
        apply_tag(where, tag, integers, reals, word);
    }

    std::size_t read_tag_count() {
        std::size_t count = 0;
        const char* const start = in_.position();
        while (in_.remaining() > 0 && *in_.position() >= '0' && *in_.position() <= '9' && count < 1'000'000) {
            count = 10 * count + static_cast<std::size_t>(*in_.position() - '0');
            in_.advance(1);
        }
        if (in_.position() == start) in_.fail_expected("counts like 2/1/0");
        if (count > in_.remaining()) in_.fail_at(start, "the tag promises more than the file holds");
        return count;
    }

    // Vertices and faces of tags are counted from 0.
    void apply_tag(const char* where, const std::string& tag, const std::vector<int>& integers,
                   const std::vector<double>& reals, const std::string& word) {
        const auto real = [&](std::size_t i) {
            if (reals.empty()) in_.fail_at(where, tag + " needs a sharpness");
            return reals[std::min(i, reals.size() - 1)];
        };
        const auto integer = [&] {
            if (integers.empty()) in_.fail_at(where, tag + " needs a whole number");
            return integers[0];
        };
        if (tag == "crease") {
            if (integers.size() % 2 != 0 || integers.empty()) in_.fail_at(where, "a crease needs two vertices");
            for (std::size_t i = 0; i + 1 < integers.size(); i += 2)
                cage_->creases.push_back({{integers[i], integers[i + 1]}, real(i / 2)});
        } else if (tag == "corner") {
            for (std::size_t i = 0; i < integers.size(); ++i) cage_->corners.push_back({integers[i], real(i)});
        } else if (tag == "hole") {
            cage_->holes.insert(cage_->holes.end(), integers.begin(), integers.end());
        } else if (tag == "interpolateboundary") {
            const int kind = integer();
            if (kind < 0 || kind > 2)
                in_.fail_at(where, "interpolateboundary is 0, 1 or 2, not " + std::to_string(kind));
            constexpr Cage::Boundary kinds[] = {Cage::Boundary::None, Cage::Boundary::EdgesAndCorners,
                                                Cage::Boundary::Edges};
            cage_->boundary = kinds[kind];
        } else if (tag == "smoothtriangles") {
            cage_->smooth_triangles = word == "smooth" || (word.empty() && integer() != 0);
        } else if (tag == "creasemethod") {
            cage_->chaikin = word == "chaikin";
        } else if (!tag.starts_with("facevarying")) {
            in_.fail_at(where, "the tag " + tag + " is not supported");
        }
    }

    const std::string& path_;
    Scanner in_;
    Cage* cage_;
    std::map<std::string, int> names_;
    int material_ = 0, group_ = 0;
    TriangleSoup soup_;
    std::vector<Fan> fans_;
    std::size_t largest_ = 0;  ///< largest vertex used before it was there
    const char* largest_where_ = nullptr;
};

}  // namespace

TriangleSoup parse_obj(const std::string& path, std::string_view text) { return ObjReader(path, text).read(); }

Cage parse_cage(const std::string& path, std::string_view text) {
    Cage cage;
    ObjReader(path, text, &cage).read();
    return cage;
}

std::string obj_text(const TriangleSoup& soup) {
    TextWriter out(64 * soup.points.size() + 32 * soup.triangles.size());
    for (const Eigen::Vector3d& p : soup.points) out << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    for (const auto& [a, b, c] : soup.triangles) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
    return out.take();
}

}  // namespace gradus::io
