#include "gradus/io/required_file.hpp"

#include "gradus/io/input_file.hpp"
#include "scanner.hpp"

namespace gradus {

namespace {

int read_index(io::Scanner& in, const char* what, std::size_t count) {
    const std::string number = std::string("the number of a ") + what;
    if (in.at_line_end()) in.fail("expected " + number + " on this line");
    const char* where = in.position();
    const std::int64_t index = in.integer_here(number.c_str());
    if (index < 1 || static_cast<std::uint64_t>(index) > count)
        in.fail_at(where, std::string("index out of range: ") + what + " " + std::to_string(index) + "; the mesh has " +
                              std::to_string(count) + ", counted from 1");
    return static_cast<int>(index) - 1;
}

}  // namespace

RequiredElements read_required(const std::string& path, std::size_t num_points, std::size_t num_triangles) {
    const std::string text = read_file(path);
    io::Scanner in(path, text, '#');
    RequiredElements required;
    while (!in.at_end()) {
        const char* where = in.position();
        const std::string_view word = in.word("an element");
        if (word == "vertex") {
            required.vertices.push_back(read_index(in, "vertex", num_points));
        } else if (word == "edge") {
            const int a = read_index(in, "vertex", num_points);
            required.edges.push_back({a, read_index(in, "vertex", num_points)});
        } else if (word == "triangle") {
            required.triangles.push_back(read_index(in, "triangle", num_triangles));
        } else {
            in.fail_at(where, "expected vertex, edge or triangle, found " + io::quoted(word));
        }
        if (!in.at_line_end()) in.fail("expected the end of the line, found " + io::quoted(in.peek()));
    }
    return required;
}

}  // namespace gradus
