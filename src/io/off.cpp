// Geomview OFF in text, with the headers OFF, COFF, NOFF, STOFF and their combinations: what follows the three
// coordinates on the line of a vertex, and the vertices on the line of a face, is passed over.
#include "formats.hpp"
#include "polygons.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

struct Header {
    bool extras = false;  ///< vertices carry more than coordinates
    std::size_t vertices = 0, faces = 0;
};

/// The header word is optional, as the format has it; the counts may stand on its line.
Header read_header(Scanner& in) {
    Header header;
    std::string_view word = in.peek();
    if (!word.empty() && (word[0] < '0' || word[0] > '9')) {
        const char* where = in.position();
        in.word("OFF");
        const std::string_view name = word;
        if (word.starts_with("ST")) word.remove_prefix(2);
        if (word.starts_with("C")) word.remove_prefix(1);
        if (word.starts_with("N")) word.remove_prefix(1);
        if (word != "OFF")
            in.fail_at(where, "is not an OFF file of points in space: expected OFF, COFF, NOFF or STOFF, found " +
                                  quoted(name));
        header.extras = name != "OFF";
        if (in.peek() == "BINARY") in.fail("binary OFF is not supported");
    }
    header.vertices = in.count("the number of vertices", 5);
    header.faces = in.count("the number of faces", 7);
    // The number of edges is often wrong, and sometimes missing.
    if (!in.at_line_end()) in.integer_here("the number of edges");
    return header;
}

void read_vertex(Scanner& in, const Header& header, TriangleSoup& soup) {
    Eigen::Vector3d point;
    in.at_end();
    for (int i = 0; i < 3; ++i) point[i] = in.real_in_line("a coordinate");
    soup.points.push_back(point);
    if (!header.extras && !in.at_line_end())
        in.fail("expected the end of the line after three coordinates (only COFF, NOFF and STOFF have more)");
    while (!in.at_line_end()) in.real_here("a number");
}

int read_index(Scanner& in, std::size_t num_vertices) {
    in.at_line_end();
    const char* where = in.position();
    const std::int64_t index = in.integer_here("a vertex of a face");
    if (index < 0 || index >= static_cast<std::int64_t>(num_vertices))
        in.fail_at(where, "vertex " + std::to_string(index) + " out of range; there are " +
                              std::to_string(num_vertices) + ", numbered from 0");
    return static_cast<int>(index);
}

void read_face(Scanner& in, TriangleSoup& soup, std::vector<Fan>& fans) {
    in.at_end();
    const char* where = in.position();
    const std::size_t corners = in.count("the number of corners", 2);
    if (corners < 3) in.fail_at(where, "a face needs at least 3 vertices, found " + std::to_string(corners));
    const int first = read_index(in, soup.points.size());
    int previous = read_index(in, soup.points.size());
    for (std::size_t i = 2; i < corners; ++i) {
        const int vertex = read_index(in, soup.points.size());
        soup.triangles.push_back({first, previous, vertex});
        previous = vertex;
    }
    if (corners > 3) fans.push_back({soup.triangles.size() - (corners - 2), corners - 2});
    while (!in.at_line_end()) in.real_here("a colour");
}

}  // namespace

TriangleSoup parse_off(const std::string& path, std::string_view text) {
    Scanner in(path, text, '#');
    const Header header = read_header(in);
    TriangleSoup soup;
    soup.points.reserve(header.vertices);
    soup.triangles.reserve(header.faces);
    std::vector<Fan> fans;
    for (std::size_t i = 0; i < header.vertices; ++i) read_vertex(in, header, soup);
    for (std::size_t i = 0; i < header.faces; ++i) read_face(in, soup, fans);
    if (!in.at_end())
        in.fail("expected the end of the file after " + std::to_string(header.faces) + " faces, found " +
                quoted(in.peek()));
    clip_ears(path, soup, fans);
    return soup;
}

std::string off_text(const TriangleSoup& soup) {
    TextWriter out(64 * soup.points.size() + 32 * soup.triangles.size());
    out << "OFF\n" << soup.points.size() << ' ' << soup.triangles.size() << " 0\n";
    for (const Eigen::Vector3d& p : soup.points) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    for (const auto& [a, b, c] : soup.triangles) out << "3 " << a << ' ' << b << ' ' << c << '\n';
    return out.take();
}

}  // namespace gradus::io
