/* Decodes the compression of V-REP's files: what `_decode` in ../huffman.py does in Python.

   A bit's place is counted from the first bit of the stream, most significant bit of each byte first. A table tells for
   each window of bits which whole codes start in it; a code that is longer is walked bit by bit. The bytes come from
   outside: every read and write is within its buffer, whatever tree and codes say. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include <stdint.h>

#define WINDOW 12 /* bits looked up at once: the table stays in the processor's first cache */
#define MOST 4    /* symbols that one look-up gives */

/* The codes that start in a window, whole ones only. */
typedef struct {
  uint8_t symbols[MOST];
  uint8_t count;
  uint8_t bits;
} Entry;

/* Two numbers for each inner node, its children: another node's index or -1 - symbol. */
static int is_valid(const int32_t* tree, Py_ssize_t size) {
  for (Py_ssize_t i = 0; i < size; i++) {
    if (tree[i] < -256 || tree[i] > size - 2 || (tree[i] > 0 && tree[i] % 2)) {
      return 0;
    }
  }
  return size > 0 && size % 2 == 0;
}

static void fill(Entry* table, const int32_t* tree) {
  for (uint32_t window = 0; window < 1u << WINDOW; window++) {
    Entry* entry = table + window;
    int32_t node = 0;
    entry->count = entry->bits = 0;
    for (int bit = 0; bit < WINDOW && entry->count < MOST; bit++) {
      node = tree[node + (window >> (WINDOW - 1 - bit) & 1)];
      if (node < 0) {
        entry->symbols[entry->count++] = (uint8_t)(-1 - node);
        entry->bits = (uint8_t)(bit + 1);
        node = 0; /* after a leaf the next code starts at the root */
      }
    }
  }
}

/* The window at a place; `place >> 3` and the two bytes behind it are within the data. */
static uint32_t window_at(const uint8_t* data, Py_ssize_t place) {
  const uint8_t* at = data + (place >> 3);
  uint32_t bits = (uint32_t)at[0] << 16 | (uint32_t)at[1] << 8 | at[2];
  return bits >> (24 - WINDOW - (place & 7)) & ((1u << WINDOW) - 1);
}

/* Fill `out`; return the place after the last code, or -1 if the data ends before. */
static Py_ssize_t run(const uint8_t* data, Py_ssize_t length, const int32_t* tree, const Entry* table,
                      Py_ssize_t place, uint8_t* out, Py_ssize_t size) {
  const Py_ssize_t end = length * 8, last = end - 24; /* the last place with a whole window */
  Py_ssize_t done = 0;
  while (done < size) {
    if (place <= last && done <= size - MOST) {
      const Entry* entry = table + window_at(data, place);
      if (entry->count) {
        for (int i = 0; i < MOST; i++) {
          out[done + i] = entry->symbols[i]; /* those that are none are written over */
        }
        done += entry->count;
        place += entry->bits;
        continue;
      }
    }
    int32_t node = 0;
    do {
      if (place >= end) {
        return -1;
      }
      node = tree[node + (data[place >> 3] >> (7 - (place & 7)) & 1)];
      place++;
    } while (node >= 0);
    out[done++] = (uint8_t)(-1 - node);
  }
  return place;
}

PyDoc_STRVAR(decode_doc,
             "decode(data, tree, place, out, /)\n--\n\n"
             "Fill `out` with the symbols of the codes from `place` on; return the place after them.\n\n"
             "-1: the data ends before. `tree`: int32, as `Tree` in huffman.py. Raises ValueError: it is no tree.");

static PyObject* decode(PyObject* module, PyObject* args) {
  Py_buffer data, tree, out;
  Py_ssize_t place;
  Entry table[1 << WINDOW];
  if (!PyArg_ParseTuple(args, "y*y*nw*", &data, &tree, &place, &out)) {
    return NULL;
  }
  if (place < 0 || data.len > PY_SSIZE_T_MAX / 8 || !is_valid(tree.buf, tree.len / (Py_ssize_t)sizeof(int32_t))) {
    PyErr_SetString(PyExc_ValueError, "this is no tree, or no place in the data");
  } else {
    Py_BEGIN_ALLOW_THREADS
    fill(table, tree.buf);
    place = run(data.buf, data.len, tree.buf, table, place, out.buf, out.len);
    Py_END_ALLOW_THREADS
  }
  PyBuffer_Release(&data);
  PyBuffer_Release(&tree);
  PyBuffer_Release(&out);
  return PyErr_Occurred() ? NULL : PyLong_FromSsize_t(place);
}

static PyMethodDef functions[] = {{"decode", decode, METH_VARARGS, decode_doc}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef definition = {
  PyModuleDef_HEAD_INIT, "_huffman", "The compression of V-REP's files, decoded.", -1, functions, NULL, NULL, NULL, NULL,
};

#ifndef SOURCE_HASH
#define SOURCE_HASH ""
#endif

PyMODINIT_FUNC PyInit__huffman(void) {
  PyObject* module = PyModule_Create(&definition);
  if (module && PyModule_AddStringConstant(module, "SOURCE_HASH", SOURCE_HASH) < 0) {
    Py_CLEAR(module);
  }
  return module;
}
