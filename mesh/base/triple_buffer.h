#pragma once
// The one-way street between two threads: a writer publishes whole values, a reader always finds the newest one.
// Neither ever waits, allocates or locks, so the servo may stand on either side.

#include <array>
#include <atomic>
#include <cstdint>

namespace retractor {

/// One writer thread, one reader thread. Three slots: one being written, one being read, one changing hands.
/// Values keep their memory: give the constructor one that already has the size it needs, and publishing allocates
/// nothing.
template <class Value> class TripleBuffer {
public:
    explicit TripleBuffer(const Value& initial = Value {})
        : slots_ { initial, initial, initial }
    {
    }
    TripleBuffer(const TripleBuffer&) = delete;
    TripleBuffer& operator=(const TripleBuffer&) = delete;

    /// Writer: the slot to fill. It holds an older value, not the last one published.
    Value& draft() noexcept { return slots_[written_]; }
    /// Writer: hands the draft over.
    void publish() noexcept
    {
        written_
            = static_cast<std::uint8_t>(handed_over_.exchange(written_ | kFresh, std::memory_order_acq_rel) & kSlot);
    }

    /// Reader: the newest published value; the reference stays valid until the next call.
    const Value& latest() noexcept
    {
        if ((handed_over_.load(std::memory_order_relaxed) & kFresh) != 0)
            read_ = static_cast<std::uint8_t>(handed_over_.exchange(read_, std::memory_order_acq_rel) & kSlot);
        return slots_[read_];
    }
    /// Reader: whether latest() would now return something else.
    [[nodiscard]] bool has_news() const noexcept
    {
        return (handed_over_.load(std::memory_order_acquire) & kFresh) != 0;
    }

private:
    static constexpr std::uint8_t kSlot = 3, kFresh = 4;
    std::array<Value, 3> slots_;
    std::uint8_t written_ = 0, read_ = 1;
    std::atomic<std::uint8_t> handed_over_ { 2 };
};

} // namespace retractor
