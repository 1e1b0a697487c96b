#pragma once
// Work for other threads while a servo is measured: a wound cut and opened again and again, and the stiffness of a body
// edited and factored again and again.

#include <atomic>
#include <exception>
#include <thread>

namespace retractor::benchmarks {

class ServoLoad {
public:
    /// @param edits with the second thread
    explicit ServoLoad(bool edits);
    /// Ends what is under way.
    ~ServoLoad();
    ServoLoad(const ServoLoad&) = delete;
    ServoLoad& operator=(const ServoLoad&) = delete;

    /// Ends it. @throws what a thread threw.
    void stop();
    [[nodiscard]] long cuts() const noexcept { return cuts_; } ///< made, opened and taken back
    [[nodiscard]] long edits() const noexcept { return edits_; } ///< of a modulus, each with a new factorisation

private:
    void cut_and_open();
    void edit();

    std::atomic<bool> stopping_ { false };
    std::atomic<long> cuts_ { 0 }, edits_ { 0 };
    std::exception_ptr cut_error_, edit_error_;
    std::thread cutter_, editor_;
};

} // namespace retractor::benchmarks
