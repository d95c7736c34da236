/* Loops that compilers fuse: prints a hash of the bits of every result. C99 and C++. SPDX-License-Identifier: MIT */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define COUNT 1021

typedef struct {
  double x, y;
} V;
typedef struct {
  float x, y;
} W;

static V p[COUNT], q[COUNT], r[COUNT];
static W s[COUNT], t[COUNT], u[COUNT];

/* Called through pointers the compiler does not see through, so that no loop is computed while compiling. */
void rotate_in_place(V* v, int n, double c, double z) {
  int i;
  for (i = 0; i < n; ++i) {
    V a = v[i];
    v[i].x = c * a.x - z * a.y;
    v[i].y = z * a.x + c * a.y;
  }
}
void rotate_floats(W* v, int n, float c, float z) {
  int i;
  for (i = 0; i < n; ++i) {
    W a = v[i];
    v[i].x = c * a.x - z * a.y;
    v[i].y = z * a.x + c * a.y;
  }
}
void multiply_complex(V* __restrict out, const V* __restrict a, const V* __restrict b, int n) {
  int i;
  for (i = 0; i < n; ++i) {
    out[i].x = a[i].x * b[i].x - a[i].y * b[i].y;
    out[i].y = a[i].y * b[i].x + a[i].x * b[i].y;
  }
}
void multiply_complex_floats(W* __restrict out, const W* __restrict a, const W* __restrict b, int n) {
  int i;
  for (i = 0; i < n; ++i) {
    out[i].x = a[i].x * b[i].x - a[i].y * b[i].y;
    out[i].y = a[i].y * b[i].x + a[i].x * b[i].y;
  }
}
void alternate(V* __restrict out, const V* __restrict a, const V* __restrict b, int n) {
  int i;
  for (i = 0; i < n; ++i) {
    out[i].x = a[i].x * b[i].x - out[i].x;
    out[i].y = a[i].y * b[i].y + out[i].y;
  }
}
void rotate_once(V* out, const V* a, double c, double z) {
  out->x = c * a->x - z * a->y;
  out->y = z * a->x + c * a->y;
}
double dot(const V* a, const V* b, int n) {
  double sum = 0;
  int i;
  for (i = 0; i < n; ++i) sum += a[i].x * b[i].x + a[i].y * b[i].y;
  return sum;
}
void polynomial(V* v, int n) {
  int i;
  for (i = 0; i < n; ++i) {
    v[i].x = ((v[i].x * 0.3 + 0.7) * v[i].x - 0.2) * v[i].x + 1.1;
    v[i].y = v[i].y * 0.9 + 0.1;
  }
}
void (*volatile rotate_in_place_)(V*, int, double, double) = rotate_in_place;
void (*volatile rotate_floats_)(W*, int, float, float) = rotate_floats;
void (*volatile multiply_complex_)(V*, const V*, const V*, int) = multiply_complex;
void (*volatile multiply_complex_floats_)(W*, const W*, const W*, int) = multiply_complex_floats;
void (*volatile alternate_)(V*, const V*, const V*, int) = alternate;
void (*volatile rotate_once_)(V*, const V*, double, double) = rotate_once;
double (*volatile dot_)(const V*, const V*, int) = dot;
void (*volatile polynomial_)(V*, int) = polynomial;

static uint64_t hash = 1469598103934665603u;
static void add(const void* data, size_t size) {
  const unsigned char* byte = (const unsigned char*)data;
  size_t i;
  for (i = 0; i < size; ++i) hash = (hash ^ byte[i]) * 1099511628211u;
}

int main(void) {
  int i;
  double product;
  for (i = 0; i < COUNT; ++i) {
    p[i].x = 1.0 / (i + 3);
    p[i].y = 1.0 / (i + 7);
    q[i].x = 1.0 / (i + 5);
    q[i].y = 1.0 / (i + 11);
    r[i] = p[i];
    s[i].x = 1.0f / (float)(i + 3);
    s[i].y = 1.0f / (float)(i + 7);
    t[i].x = 1.0f / (float)(i + 5);
    t[i].y = 0.3f;
    u[i] = s[i];
  }
  for (i = 0; i < 20; ++i) rotate_in_place_(p, COUNT, 0.8, 0.6);
  add(p, sizeof p);
  for (i = 0; i < 20; ++i) rotate_floats_(s, COUNT, 0.8f, 0.6f);
  add(s, sizeof s);
  multiply_complex_(r, p, q, COUNT);
  add(r, sizeof r);
  multiply_complex_floats_(u, s, t, COUNT);
  add(u, sizeof u);
  alternate_(r, p, q, COUNT);
  add(r, sizeof r);
  for (i = 0; i < 20; ++i) rotate_once_(&q[i], &p[i], 0.8, 0.6);
  add(q, sizeof q);
  product = dot_(p, q, COUNT);
  add(&product, sizeof product);
  polynomial_(p, COUNT);
  add(p, sizeof p);
  printf("%016llx\n", (unsigned long long)hash);
  return 0;
}
