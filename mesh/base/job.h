#pragma once
// What long work is given besides its input: a way to report progress, to be cancelled, and a
// ledger of the parts it builds (for `--profile` and for the tests that assert that a scene does
// not build what it does not need).

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace retractor {

/// One part that was built: voxels, tetrahedra, a factorisation, a ray tracer, a renderer ...
struct BuiltPart {
    std::string name;
    double seconds = 0.0;
    std::size_t bytes = 0; ///< memory owned by the part, as its builder counts it
};

/// The parts built so far, in order. Safe to use from several threads.
class Ledger {
public:
    void add(BuiltPart part);
    std::vector<BuiltPart> parts() const;
    bool has(std::string_view name) const;

private:
    mutable std::mutex mutex_;
    std::vector<BuiltPart> parts_;
};

/// Handed down by const reference; a default-made Job reports nothing and is never cancelled.
struct Job {
    /// Called with a stage name and the done fraction of that stage, 0 to 1.
    std::function<void(std::string_view stage, double fraction)> on_progress;
    const std::atomic<bool>* cancel = nullptr;
    Ledger* ledger = nullptr;
    int threads = 2; ///< how many the work may use at once

    void report(std::string_view stage, double fraction) const
    {
        if (on_progress)
            on_progress(stage, fraction);
    }
    bool cancelled() const { return cancel != nullptr && cancel->load(std::memory_order_relaxed); }
};

/// Wall clock seconds since construction.
class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Records a built part, timed since the stopwatch started; does nothing without a ledger.
void record_part(const Job& job, std::string_view name, const Stopwatch& watch, std::size_t bytes);

} // namespace retractor
