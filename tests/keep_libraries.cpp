// Memory that a graphics driver never frees can be told from ours only as long as the driver is loaded.
#ifdef __SANITIZE_ADDRESS__
extern "C" int dlclose(void*) { return 0; }
#endif
