#pragma once
// VTK reports errors as text and carries on. While one of these lives, that text is collected instead of printed.

#include <string>

namespace retractor::ui {

class VtkErrorTrap {
public:
    VtkErrorTrap();
    ~VtkErrorTrap();
    VtkErrorTrap(const VtkErrorTrap&) = delete;
    VtkErrorTrap& operator=(const VtkErrorTrap&) = delete;

    /// All error messages so far, in one line; empty when there is none.
    std::string errors() const;
    /// @throws IoError with the collected errors, when there is one. @param doing what was attempted.
    void throw_if_error(const std::string& doing) const;

private:
    struct State;
    State* state_;
};

} // namespace retractor::ui
