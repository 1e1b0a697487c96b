#pragma once
// Collects VTK's error messages of its thread during its lifetime. VTK would print them and carry on. A message from a
// thread without a trap goes to the oldest trap.

#include <string>

namespace retractor {

class VtkErrorTrap {
public:
    VtkErrorTrap();
    ~VtkErrorTrap();
    VtkErrorTrap(const VtkErrorTrap&) = delete;
    VtkErrorTrap& operator=(const VtkErrorTrap&) = delete;

    /// All error messages so far, in one line; empty when there is none.
    std::string errors() const;
    /// @throws IoError with the collected errors, when there are any
    /// @param doing name of the step, for the message
    void throw_if_error(const std::string& doing) const;

    struct State;

private:
    State* state_;
};

} // namespace retractor
