#pragma once
// A hash map with open addressing and linear probing. A look-up costs a few instructions. Values lie in chunks, so that
// a reference to a value stays valid until its key is erased. The map cannot be iterated.

#include "mesh/base/assert.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace retractor {

template <class Value> class OpenAddressMap {
public:
    /// The value of a key. When the key is missing, the function adds Value {} and sets `is_new`.
    Value& at(std::uint64_t key, bool& is_new)
    {
        if (2 * (size_ + 1) > table_.size())
            grow();
        RETRACTOR_ASSERT(std::has_single_bit(table_.size()) && size_ < table_.size());
        std::size_t i = home(key);
        while (table_[i].value != nullptr) {
            if (table_[i].key == key) {
                is_new = false;
                return *table_[i].value;
            }
            i = (i + 1) & (table_.size() - 1);
        }
        is_new = true;
        ++size_;
        table_[i] = { key, take() };
        return *table_[i].value;
    }

    void erase(std::uint64_t key)
    {
        if (table_.empty())
            return;
        const std::size_t mask = table_.size() - 1;
        std::size_t hole = home(key);
        while (table_[hole].value != nullptr && table_[hole].key != key)
            hole = (hole + 1) & mask;
        if (table_[hole].value == nullptr)
            return;
        RETRACTOR_ASSERT(size_ > 0);
        free_.push_back(table_[hole].value);
        --size_;
        // An entry that a look-up would reach only through the hole moves into the hole (Knuth, The Art of Computer
        // Programming 3, section 6.4, algorithm R).
        for (std::size_t i = (hole + 1) & mask; table_[i].value != nullptr; i = (i + 1) & mask)
            if (((i - home(table_[i].key)) & mask) >= ((i - hole) & mask)) {
                table_[hole] = table_[i];
                hole = i;
            }
        table_[hole].value = nullptr;
    }

private:
    struct Place {
        std::uint64_t key = 0;
        Value* value = nullptr; ///< null: the slot is free
    };
    static constexpr std::size_t kChunk = 64, kFirstTable = 256;

    std::size_t home(std::uint64_t key) const
    {
        // Fibonacci hashing: the upper bits of key * 2^64 / golden ratio.
        return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> shift_);
    }

    Value* take()
    {
        if (!free_.empty()) {
            Value* value = free_.back();
            free_.pop_back();
            *value = Value {};
            return value;
        }
        if (in_last_ == kChunk) {
            chunks_.push_back(std::make_unique<std::array<Value, kChunk>>());
            in_last_ = 0;
        }
        return &(*chunks_.back())[in_last_++];
    }

    void grow()
    {
        std::vector<Place> old(table_.empty() ? kFirstTable : 2 * table_.size());
        old.swap(table_);
        shift_ = 64 - std::countr_zero(table_.size());
        for (const Place& place : old)
            if (place.value != nullptr) {
                std::size_t i = home(place.key);
                while (table_[i].value != nullptr)
                    i = (i + 1) & (table_.size() - 1);
                table_[i] = place;
            }
    }

    std::vector<Place> table_; ///< slots; their number is a power of two
    int shift_ = 64;
    std::size_t size_ = 0, in_last_ = kChunk;
    std::vector<std::unique_ptr<std::array<Value, kChunk>>> chunks_;
    std::vector<Value*> free_;
};

} // namespace retractor
