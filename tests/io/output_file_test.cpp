#include "gradus/io/output_file.hpp"

#include <sys/resource.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "gradus/io/error.hpp"
#include "gradus/io/input_file.hpp"
#include "support/files.hpp"

using namespace gradus;
namespace fs = std::filesystem;

namespace {

std::size_t num_files(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// Files of this process may not grow beyond `bytes`: a full disk, as far as a writer sees.
class FullDisk {
  public:
    explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        ::getrlimit(RLIMIT_FSIZE, &old_);
        rlimit limit = old_;
        limit.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FullDisk() {
        ::setrlimit(RLIMIT_FSIZE, &old_);
        std::signal(SIGXFSZ, handler_);
    }

  private:
    rlimit old_{};
    void (*handler_)(int);
};

}  // namespace

TEST_CASE("a written file reads back, and nothing is left beside it", "[io]") {
    const support::TemporaryFolder folder;
    const std::string path = folder / "a.bin", contents("\0\n\r\xff one", 9);
    write_file(path, "before");
    write_file(path, contents);
    CHECK(read_file(path) == contents);
    write_file(folder / "empty", "");
    CHECK(read_file(folder / "empty").empty());
    CHECK(num_files(folder.path()) == 2);
}

TEST_CASE("a failed write keeps the old file and leaves no other", "[io]") {
    const support::TemporaryFolder folder;
    const std::string path = folder / "a.txt";
    write_file(path, "precious");
    {
        const FullDisk full(1000);
        CHECK_THROWS_AS(write_file(path, std::string(5000, 'x')), IoError);
    }
    CHECK(read_file(path) == "precious");
    CHECK(num_files(folder.path()) == 1);
}

TEST_CASE("targets that cannot be written are named", "[io]") {
    const support::TemporaryFolder folder;
    CHECK_THROWS_WITH(write_file(folder / "none/a.txt", "x"), Catch::StartsWith(folder / "none/a.txt: "));
    CHECK_THROWS_WITH(write_file(folder.path().string(), "x"), Catch::Contains("is a directory"));
    CHECK_THROWS_AS(write_file("", "x"), IoError);
    CHECK_THROWS_AS(write_file("/dev/full", "x"), IoError);
    CHECK_NOTHROW(write_file("/dev/null", "x"));
}

TEST_CASE("links are followed and permissions kept", "[io]") {
    const support::TemporaryFolder folder;
    write_file(folder / "real", "old");
    ::chmod((folder / "real").c_str(), 0640);
    fs::create_symlink("real", folder / "link");
    write_file(folder / "link", "new");
    CHECK(fs::is_symlink(folder / "link"));
    CHECK(read_file(folder / "real") == "new");
    CHECK((fs::status(folder / "real").permissions() & fs::perms::mask) == fs::perms(0640));
}

TEST_CASE("what cannot be read is named", "[io]") {
    const support::TemporaryFolder folder;
    CHECK_THROWS_WITH(read_file(folder / "none"), Catch::StartsWith(folder / "none: cannot be opened"));
    CHECK_THROWS_WITH(read_file(folder.path().string()), Catch::Contains("is a directory"));
}
