/// A bound on what a test may allocate.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace support {

/// While it lives, the process may grow by so many bytes of address space, touched or not: beyond, `new` throws.
class MemoryLimit {
  public:
    explicit MemoryLimit(rlim_t bytes) {
        rlim_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        ::getrlimit(RLIMIT_AS, &before_);
        rlimit limit = before_;
        limit.rlim_cur = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + bytes;
        ::setrlimit(RLIMIT_AS, &limit);
    }
    ~MemoryLimit() { ::setrlimit(RLIMIT_AS, &before_); }
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

  private:
    rlimit before_{};
};

}  // namespace support
