#pragma once
// A Job accompanies long work: it reports progress, carries the request to cancel, and refers to a ledger of the parts
// that the work builds. `--profile` prints the ledger, and tests check with it that a scene builds nothing that it does
// not need.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace retractor {

/// A part that was built, such as voxels, tetrahedra, a factorisation, a ray tracer or a renderer.
struct BuiltPart {
    std::string name;
    double seconds = 0.0; ///< time of building (s)
    std::size_t bytes = 0; ///< memory that the part owns, as its builder counts it
};

/// The parts built so far, in order. Several threads may use a ledger at once.
class Ledger {
public:
    void add(BuiltPart part);
    std::vector<BuiltPart> parts() const;
    bool has(std::string_view name) const;

private:
    mutable std::mutex mutex_;
    std::vector<BuiltPart> parts_;
};

/// Callers pass a Job by const reference. A default Job reports nothing and is never cancelled.
struct Job {
    /// Called with the name of a stage and the finished fraction of that stage, 0 to 1.
    std::function<void(std::string_view stage, double fraction)> on_progress;
    const std::atomic<bool>* cancel = nullptr; ///< true asks the work to stop; null: the work cannot be cancelled
    Ledger* ledger = nullptr; ///< receives the parts built; may be null
    int threads = 2; ///< largest number of threads that the work may use

    void report(std::string_view stage, double fraction) const
    {
        if (on_progress)
            on_progress(stage, fraction);
    }
    bool cancelled() const { return cancel != nullptr && cancel->load(std::memory_order_relaxed); }
};

/// Wall-clock seconds since construction.
class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Adds a part to the job's ledger, with the time since the stopwatch started. Does nothing without a ledger.
void record_part(const Job& job, std::string_view name, const Stopwatch& watch, std::size_t bytes);

} // namespace retractor
