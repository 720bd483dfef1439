// STL, text and binary. The format repeats the corners of every triangle; they are welded where their coordinates are
// equal.
#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "bytes.hpp"
#include "formats.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

/// Numbers points in the order they first come, equal ones alike. A hash table with open addressing: its order is never
/// seen.
class Weld {
  public:
    explicit Weld(std::size_t expected_triangles) {
        soup_.triangles.reserve(expected_triangles);
        table_.assign(std::bit_ceil(std::max<std::size_t>(64, expected_triangles)), kFree);
    }

    int index_of(const Eigen::Vector3d& point) {
        std::size_t slot = hash(point) & (table_.size() - 1);
        for (; table_[slot] != kFree; slot = (slot + 1) & (table_.size() - 1))
            if (soup_.points[static_cast<std::size_t>(table_[slot])] == point) return table_[slot];
        table_[slot] = static_cast<int>(soup_.points.size());
        soup_.points.push_back(point);
        if (2 * soup_.points.size() > table_.size()) grow();
        return static_cast<int>(soup_.points.size()) - 1;
    }

    void add(const Triangle& triangle) { soup_.triangles.push_back(triangle); }
    TriangleSoup take() { return std::move(soup_); }

  private:
    static constexpr int kFree = -1;

    static std::size_t hash(const Eigen::Vector3d& point) {
        std::uint64_t h = 0;
        for (int i = 0; i < 3; ++i) {
            // Adding 0 makes 0 of -0, which equals it.
            h = (h ^ std::bit_cast<std::uint64_t>(point[i] + 0.0)) * 0x9E3779B97F4A7C15u;
            h ^= h >> 32;
        }
        return static_cast<std::size_t>(h);
    }

    void grow() {
        table_.assign(2 * table_.size(), kFree);
        for (std::size_t i = 0; i < soup_.points.size(); ++i) {
            std::size_t slot = hash(soup_.points[i]) & (table_.size() - 1);
            while (table_[slot] != kFree) slot = (slot + 1) & (table_.size() - 1);
            table_[slot] = static_cast<int>(i);
        }
    }

    TriangleSoup soup_;
    std::vector<int> table_;
};

bool same_word(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
    });
}

void expect(Scanner& in, const char* expected) {
    in.at_end();
    if (!same_word(in.peek(), expected)) in.fail_expected(expected);
    in.word(expected);
}

void read_facet(Scanner& in, Weld& weld) {
    expect(in, "normal");
    // Not looked at: many files have nonsense here, not-a-number on flat triangles above all.
    for (int i = 0; i < 3; ++i) in.word("a normal");
    expect(in, "outer");
    expect(in, "loop");
    Triangle triangle;
    for (int& vertex : triangle) {
        expect(in, "vertex");
        Eigen::Vector3d point;
        for (int i = 0; i < 3; ++i) point[i] = in.real("a coordinate");
        vertex = weld.index_of(point);
    }
    expect(in, "endloop");
    expect(in, "endfacet");
    weld.add(triangle);
}

TriangleSoup parse_text(const std::string& path, std::string_view text) {
    Scanner in(path, text, '\0');
    constexpr std::size_t kLeastFacet = 80;  // characters of a facet with coordinates of one digit
    Weld weld(text.size() / (3 * kLeastFacet));
    while (!in.at_end()) {
        expect(in, "solid");
        in.next_line();  // a name of any words
        while (same_word(in.peek(), "facet")) {
            in.word("facet");
            read_facet(in, weld);
        }
        if (!same_word(in.peek(), "endsolid")) in.fail_expected("facet or endsolid");
        in.next_line();
    }
    return weld.take();
}

constexpr std::size_t kBinaryHeader = 80;
constexpr std::size_t kBinaryFacet = 50;

TriangleSoup parse_binary(const std::string& path, std::string_view bytes) {
    ByteReader in(path, bytes);
    in.skip(kBinaryHeader, "a binary STL header (the file does not start with 'solid' as a text one)");
    const auto count = in.get<std::uint32_t>("the number of triangles");
    in.check_count(count, kBinaryFacet, "the number of triangles");
    if (in.remaining() != count * kBinaryFacet)
        in.fail_at(kBinaryHeader, "the number of triangles is " + std::to_string(count) + ", but " +
                                      std::to_string(in.remaining() - count * kBinaryFacet) +
                                      " bytes follow the last one");
    Weld weld(count);
    for (std::uint32_t t = 0; t < count; ++t) {
        in.skip(12, "a normal");
        Triangle triangle;
        for (int& vertex : triangle) {
            const std::size_t where = in.offset();
            Eigen::Vector3d point;
            for (int i = 0; i < 3; ++i) point[i] = static_cast<double>(in.get<float>("a coordinate"));
            if (!point.allFinite()) in.fail_at(where, "a coordinate is not finite");
            vertex = weld.index_of(point);
        }
        in.skip(2, "an attribute");
        weld.add(triangle);
    }
    return weld.take();
}

/// Unit normal; zero for a triangle without one, as the format has it.
Eigen::Vector3d normal_of(const TriangleSoup& soup, const Triangle& triangle) {
    const Eigen::Vector3d& a = soup.points[static_cast<std::size_t>(triangle[0])];
    const Eigen::Vector3d normal = (soup.points[static_cast<std::size_t>(triangle[1])] - a)
                                       .cross(soup.points[static_cast<std::size_t>(triangle[2])] - a);
    const double length = normal.stableNorm();
    return length > 0 && std::isfinite(length) ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}

}  // namespace

TriangleSoup parse_stl(const std::string& path, std::string_view contents) {
    // Binary headers may start with "solid" too, so the size decides first.
    if (contents.size() >= kBinaryHeader + 4) {
        std::uint32_t count = 0;
        std::memcpy(&count, contents.data() + kBinaryHeader, sizeof count);
        if (contents.size() == kBinaryHeader + 4 + count * kBinaryFacet) return parse_binary(path, contents);
    }
    Scanner in(path, contents, '\0');
    return same_word(in.peek(), "solid") ? parse_text(path, contents) : parse_binary(path, contents);
}

std::string stl_text(const TriangleSoup& soup) {
    TextWriter out(320 * soup.triangles.size() + 64);
    out << "solid gradus\n";
    for (const Triangle& triangle : soup.triangles) {
        const Eigen::Vector3d normal = normal_of(soup, triangle);
        out << "facet normal " << normal[0] << ' ' << normal[1] << ' ' << normal[2] << "\n outer loop\n";
        for (const int vertex : triangle) {
            const Eigen::Vector3d& p = soup.points[static_cast<std::size_t>(vertex)];
            out << "  vertex " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
        }
        out << " endloop\nendfacet\n";
    }
    out << "endsolid gradus\n";
    return out.take();
}

std::string stl_binary(const TriangleSoup& soup) {
    std::string bytes = "binary STL of gradus";
    bytes.reserve(kBinaryHeader + 4 + kBinaryFacet * soup.triangles.size());
    bytes.resize(kBinaryHeader, ' ');
    append_bytes(bytes, static_cast<std::uint32_t>(soup.triangles.size()));
    const auto append_point = [&](const Eigen::Vector3d& p) {
        for (int i = 0; i < 3; ++i) append_bytes(bytes, static_cast<float>(p[i]));
    };
    for (const Triangle& triangle : soup.triangles) {
        append_point(normal_of(soup, triangle));
        for (const int vertex : triangle) {
            const Eigen::Vector3d& p = soup.points[static_cast<std::size_t>(vertex)];
            if (!p.cast<float>().allFinite())
                throw std::invalid_argument("write_mesh: vertex " + std::to_string(vertex) +
                                            " is beyond single precision, which binary STL is limited to; use text");
            append_point(p);
        }
        append_bytes(bytes, std::uint16_t{0});
    }
    return bytes;
}

}  // namespace gradus::io
