// The functions of SDL2 that the window calls, from a libSDL2 that is found when the window opens.
// SPDX-License-Identifier: MIT
//
// The packaged tool has this file in place of the library, so that it starts on machines without SDL2.
#include <SDL2/SDL.h>
#include <dlfcn.h>

namespace {

constexpr const char* library_name = "libSDL2-2.0.so.0";

/// Null where there is no such library, or no such function in it.
void* find(const char* function) {
  static void* const library = dlopen(library_name, RTLD_NOW | RTLD_LOCAL);
  return library == nullptr ? nullptr : dlsym(library, function);
}

}  // namespace

// A function without a library gives nothing: null, zero, false.
#define TICKTRUE_FORWARD(Result, name, parameters, ...)                          \
  extern "C" Result name parameters {                                            \
    using Nothing = Result;                                                      \
    static const auto function = reinterpret_cast<decltype(&name)>(find(#name)); \
    return function == nullptr ? Nothing() : function(__VA_ARGS__);              \
  }

TICKTRUE_FORWARD(int, SDL_ConvertPixels,
                 (int width, int height, Uint32 source_format, const void* source, int source_pitch, Uint32 format,
                  void* pixels, int pitch),
                 width, height, source_format, source, source_pitch, format, pixels, pitch)
TICKTRUE_FORWARD(SDL_Window*, SDL_CreateWindow, (const char* title, int x, int y, int width, int height, Uint32 flags),
                 title, x, y, width, height, flags)
TICKTRUE_FORWARD(void, SDL_DestroyWindow, (SDL_Window * window), window)
TICKTRUE_FORWARD(const char*, SDL_GetKeyName, (SDL_Keycode key), key)
TICKTRUE_FORWARD(Uint32, SDL_GetTicks, (void))
TICKTRUE_FORWARD(SDL_Surface*, SDL_GetWindowSurface, (SDL_Window * window), window)
TICKTRUE_FORWARD(int, SDL_LockSurface, (SDL_Surface * surface), surface)
TICKTRUE_FORWARD(int, SDL_PollEvent, (SDL_Event * event), event)
TICKTRUE_FORWARD(void, SDL_Quit, (void))
TICKTRUE_FORWARD(SDL_bool, SDL_SetHint, (const char* name, const char* value), name, value)
TICKTRUE_FORWARD(void, SDL_SetWindowTitle, (SDL_Window * window, const char* title), window, title)
TICKTRUE_FORWARD(void, SDL_UnlockSurface, (SDL_Surface * surface), surface)
TICKTRUE_FORWARD(int, SDL_UpdateWindowSurface, (SDL_Window * window), window)
TICKTRUE_FORWARD(int, SDL_setenv, (const char* name, const char* value, int overwrite), name, value, overwrite)

extern "C" int SDL_Init(Uint32 flags) {
  static const auto function = reinterpret_cast<decltype(&SDL_Init)>(find("SDL_Init"));
  return function == nullptr ? -1 : function(flags);
}

extern "C" const char* SDL_GetError(void) {
  static const auto function = reinterpret_cast<decltype(&SDL_GetError)>(find("SDL_GetError"));
  return function == nullptr ? "found no libSDL2-2.0.so.0 (Debian: libsdl2-2.0-0)" : function();
}
