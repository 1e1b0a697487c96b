#pragma once
// Passes values from one thread to another: a writer publishes whole values, and a reader gets the newest value.
// Neither thread waits, allocates or locks, so that the servo may be the writer or the reader.

#include <array>
#include <atomic>
#include <cstdint>

namespace retractor {

/// For one writer thread and one reader thread. Of three slots, one is being written, one is being read, and one is
/// handed over. Slots keep their memory: when the initial value has its final size, publishing allocates nothing.
template <class Value> class TripleBuffer {
public:
    explicit TripleBuffer(const Value& initial = Value {})
        : slots_ { initial, initial, initial }
    {
    }
    TripleBuffer(const TripleBuffer&) = delete;
    TripleBuffer& operator=(const TripleBuffer&) = delete;

    /// Writer: the slot to fill. The slot holds an older value, not the last published value.
    Value& draft() noexcept { return slots_[written_]; }
    /// Writer: hands the draft over to the reader.
    void publish() noexcept
    {
        written_
            = static_cast<std::uint8_t>(handed_over_.exchange(written_ | kFresh, std::memory_order_acq_rel) & kSlot);
    }

    /// Reader: the newest published value. The reference is valid until the next call.
    const Value& latest() noexcept
    {
        if ((handed_over_.load(std::memory_order_relaxed) & kFresh) != 0)
            read_ = static_cast<std::uint8_t>(handed_over_.exchange(read_, std::memory_order_acq_rel) & kSlot);
        return slots_[read_];
    }
    /// Reader: true when latest() would return a newer value.
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
