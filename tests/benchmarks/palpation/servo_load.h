#pragma once
// Load on other threads while a servo is measured: one thread cuts and opens a wound repeatedly, another edits and
// factorises the stiffness of a body repeatedly.

#include <atomic>
#include <exception>
#include <thread>

namespace retractor::benchmarks {

class ServoLoad {
public:
    /// @param edits starts the second thread
    explicit ServoLoad(bool edits);
    /// Stops the threads.
    ~ServoLoad();
    ServoLoad(const ServoLoad&) = delete;
    ServoLoad& operator=(const ServoLoad&) = delete;

    /// Stops the threads.
    /// @throws the exception that a thread threw.
    void stop();
    [[nodiscard]] long cuts() const noexcept { return cuts_; } ///< number of wounds cut, opened and undone
    /// number of edits of a modulus, each with a new factorisation
    [[nodiscard]] long edits() const noexcept { return edits_; }

private:
    void cut_and_open();
    void edit();

    std::atomic<bool> stopping_ { false };
    std::atomic<long> cuts_ { 0 }, edits_ { 0 };
    std::exception_ptr cut_error_, edit_error_;
    std::thread cutter_, editor_;
};

} // namespace retractor::benchmarks
