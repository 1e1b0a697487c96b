// Stands for the driver's own library, which broken_hd needs and does not find.
extern "C" int missing_driver() { return 42; }
